"""``bt-controller check``: load and check a tree without running it."""

from __future__ import annotations

import json
import sys
from typing import TYPE_CHECKING, Final

from bt_controller.cli._codes import DONE, EXIT_CODES
from bt_controller.cli._tree_options import add_tree_options, tree_of
from bt_controller.cli._watching import add_picture_options, draw
from bt_controller.running.mission import Mission

if TYPE_CHECKING:
    import argparse

_EXAMPLES: Final = """\
examples:
  bt-controller check navigate.xml && bt-controller run navigate.xml --robot wall_e --set goal=kitchen
  bt-controller check missions.xml --tree Fetch --nodes my_nodes
  bt-controller check missions:patrol && bt-controller run missions:patrol --robot wall_e
  bt-controller check missions:patrol --json | jq '.nodes | length'"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``bt-controller check``."""
    parser.description = (
        "Load a tree, build it and print it; nothing is sent. Each mistake of a file is a line of its own;"
        " what is still to be given with --set is told, too, and no mistake."
    )
    parser.epilog = f"{_EXAMPLES}\n\n{EXIT_CODES}"
    add_tree_options(parser)
    parser.add_argument("--json", action="store_true", help="print the tree as one JSON object")
    add_picture_options(parser)
    parser.set_defaults(command=_check)


def _check(args: argparse.Namespace) -> int:
    plan = tree_of(args)
    nodes = Mission("robot", plan).snapshot(None).nodes
    for line in plan.unset:
        print(f"bt-controller: {line}", file=sys.stderr)
    draw(args, {args.tree: nodes}, statuses=False)
    if args.dot == "-":
        return DONE
    if args.json:
        wanted = ("depth", "symbol", "kind", "name")
        print(json.dumps({"tree": args.tree, "nodes": [{key: getattr(node, key) for key in wanted} for node in nodes]}))
        return DONE
    for node in nodes:
        print(node.line(status=False))
    return DONE
