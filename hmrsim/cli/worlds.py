"""The world that a command line names."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from hmrsim.settings.arguments import read_settings
from hmrsim.settings.world import WorldSettings
from hmrsim.world import ReadOptions
from hmrsim.world.options import renames
from hmrsim.world_checks import load_world

if TYPE_CHECKING:
    import argparse
    from collections.abc import Mapping

    from hmrsim.world_checks import LoadedWorld


def read_world(
    args: argparse.Namespace, *, argument: str = "world", below: Mapping[str, Any] | None = None
) -> LoadedWorld:
    """Read the world that a command line names, with its additions.

    Args:
        args: The command line.
        argument: What the world is called there.
        below: The settings of a file.

    Raises:
        WorldError: It is not valid.
    """
    settings = read_settings(args, WorldSettings, below)
    options = ReadOptions(settings.page, renames(settings.rename), settings.lenient, settings.neighbours)
    return load_world(getattr(args, argument), add_robots=settings.robot, add_items=settings.item, options=options)
