"""What ``bt-controller check`` does: it builds a tree, and prints it."""

from __future__ import annotations

import argparse
import json
import sys

from bt_controller.cli._codes import DONE
from bt_controller.cli._trees import tree_of
from bt_controller.cli._watching import check_files, draw
from bt_controller.running.mission import Mission
from hmrsim.errors import printable


def check(args: argparse.Namespace) -> int:
    """Build the tree that the options select, and print it; return the exit code."""
    plan = tree_of(args)
    check_files(args, plan)
    nodes = Mission("robot", plan).snapshot(None).nodes
    for line in plan.unset:
        print(f"bt-controller: {printable(line)}", file=sys.stderr)
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
