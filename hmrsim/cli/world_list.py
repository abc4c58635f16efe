"""``hmrsim world list``: the worlds that are shipped."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from hmrsim.cli.exits import ExitCode
from hmrsim.cli.output import show, show_json
from hmrsim.world.files import shipped_maps

if TYPE_CHECKING:
    from pathlib import Path


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim world list``."""
    parser.description = "List the worlds that are shipped: names that stand for WORLD everywhere."
    parser.epilog = "examples:\n  hmrsim world list\n  hmrsim world list --json | jq -r '.cafe.file'"
    parser.add_argument("--json", action="store_true", help="print one JSON object: a world's text and file, by name")
    parser.set_defaults(function=_list)


def _list(args: argparse.Namespace) -> int:
    worlds = {name: {"text": _text(path), "file": str(path)} for name, path in shipped_maps().items()}
    if args.json:
        show_json(worlds)
        return ExitCode.DONE
    width = max(map(len, worlds))
    for name, world in worlds.items():
        show(f"{name:{width}}  {world['text']}")
    return ExitCode.DONE


def _text(path: Path) -> str:
    """Return the first sentence of a file's comment, without the dot."""
    lines = [line.removeprefix("#").strip() for line in path.read_text(encoding="utf-8").splitlines()[1:]]
    comment = lines[: next(number for number, line in enumerate(lines) if line.startswith("name:"))]
    return " ".join(comment).strip().partition(". ")[0].removesuffix(".")
