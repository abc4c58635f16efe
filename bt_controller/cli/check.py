"""``bt-controller check``: load and check a tree without running it."""

from __future__ import annotations

import argparse
import json
from typing import Any, Final

from bt_controller.cli._codes import DONE, EXIT_CODES

# What takes its time to load (py_trees, pydantic, zenoh) is imported where it is needed: --help is quick.
# ruff: noqa: PLC0415

_EXAMPLES: Final = """\
examples:
  bt-controller check bt_controller.examples:go_to_pose
  bt-controller check missions:patrol && bt-controller run missions:patrol --robot wall_e
  bt-controller check missions:patrol --json | jq '.nodes | length'"""


def add_parser(commands: Any) -> None:
    """Add the command."""
    parser = commands.add_parser(
        "check",
        help="load and check a tree without running it",
        description="Load a tree, build it and print it; nothing is sent.",
        epilog=f"{_EXAMPLES}\n\n{EXIT_CODES}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("tree", metavar="TREE", help="MODULE:FUNCTION")
    parser.add_argument("--json", action="store_true", help="print the tree as one JSON object")
    parser.set_defaults(command=_check)


def _check(args: argparse.Namespace) -> int:
    from bt_controller.mission import Mission
    from bt_controller.trees import load

    nodes = Mission("robot", load(args.tree)).snapshot(None).nodes
    if args.json:
        wanted = ("depth", "symbol", "kind", "name")
        print(json.dumps({"tree": args.tree, "nodes": [{key: getattr(node, key) for key in wanted} for node in nodes]}))
        return DONE
    for node in nodes:
        print(node.line(status=False))
    return DONE
