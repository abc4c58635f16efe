"""What ``bt-controller check`` does: it builds a tree, and prints it."""

from __future__ import annotations

import argparse
import json
import sys
from typing import TYPE_CHECKING

from bt_controller.cli._codes import DONE
from bt_controller.cli._trees import tree_of
from bt_controller.cli._watching import check_files, draw
from bt_controller.errors import TreeError
from bt_controller.running.mission import missions_for
from hmrsim.errors import printable

if TYPE_CHECKING:
    from collections.abc import Sequence

    from bt_controller.loading.trees import Plan
    from bt_controller.running.mission import Mission


def check(args: argparse.Namespace) -> int:
    """Build the tree that the options select, and print it; return the exit code."""
    plan = tree_of(args)
    check_files(args, plan)
    nodes = _built(plan, args.robot).snapshot(None).nodes
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


def _built(plan: Plan, robots: Sequence[str]) -> Mission:
    """Return the mission of some robots, or of one of any name.

    Raises:
        TreeError: The tree can't be built.
    """
    try:
        return missions_for(robots or ["robot"], plan)[0]
    except TreeError as error:
        if plan.takes_robots and not robots:
            raise TreeError(f"{error}; it was given one robot, others are named by --robot") from None
        raise
