"""The options of every command that takes a WORLD."""

from __future__ import annotations

import argparse

from hmrsim.settings.arguments import add_settings
from hmrsim.settings.run import WorldSettings


def add_world_options(parser: argparse.ArgumentParser, *, argument: str = "world") -> None:
    """Add WORLD and its options to a command."""
    add_world_argument(parser, argument=argument)
    add_settings(parser, WorldSettings)


def add_world_argument(parser: argparse.ArgumentParser, *, argument: str = "world") -> None:
    """Add WORLD only to a command."""
    parser.add_argument(
        argument, metavar=argument.upper(), help="a world file of any format, or the name of a shipped world"
    )
