"""``hmrsim world schema``: the schema of world files."""

from __future__ import annotations

import argparse

from hmrsim.cli.exits import ExitCode
from hmrsim.cli.output import show
from hmrsim.world.files import folder


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim world schema``."""
    parser.description = (
        "Print the JSON Schema of world files. An editor with support for YAML finds it by the first line of a world: "
        "# yaml-language-server: $schema=world.schema.json"
    )
    parser.epilog = "examples:\n  hmrsim world schema > world.schema.json"
    parser.set_defaults(function=_schema)


def _schema(_args: argparse.Namespace) -> int:
    show((folder("schemas") / "world.schema.json").read_text(encoding="utf-8").rstrip("\n"))
    return ExitCode.DONE
