"""``bt-controller check``: load and check a tree without running it."""

from __future__ import annotations

import argparse
import json
import sys
from typing import TYPE_CHECKING, Final

from bt_controller.cli._options import (
    DONE,
    EXIT_CODES,
    add_picture_options,
    add_robot_option,
    add_tree_options,
    tree_of,
)
from bt_controller.errors import TreeError
from hmrsim.errors import printable

if TYPE_CHECKING:
    from collections.abc import Sequence

    from bt_controller.loading.trees import Plan
    from bt_controller.running.snapshot import Node

_EXAMPLES: Final = """\
examples:
  bt-controller check navigate.xml && bt-controller run navigate.xml --robot mocha --set goal=kitchen
  bt-controller check missions.xml --tree Fetch --nodes my_nodes
  bt-controller check missions:patrol && bt-controller run missions:patrol --robot mocha
  bt-controller check missions:hand_over --robot mocha latte
  bt-controller check missions:patrol --json | jq '.nodes | length'"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``bt-controller check``."""
    parser.description = (
        "Load a tree, build it and print it; nothing is sent. Each error in a file is reported on its own line. Values"
        " that have to be given with --set are also reported, but are not errors."
    )
    parser.epilog = f"{_EXAMPLES}\n\n{EXIT_CODES}"
    add_tree_options(parser)
    add_robot_option(parser, "the robots that the tree is built for, if one tree is for several (default: robot)")
    parser.add_argument("--json", action="store_true", help="print the tree as one JSON object")
    add_picture_options(parser)
    parser.set_defaults(function=_check)


def _check(args: argparse.Namespace) -> int:
    from bt_controller.cli._watching import check_files, draw

    plan = tree_of(args)
    check_files(args, plan)
    trees = _trees(args.tree, plan, args.robot)
    for line in plan.unset:
        print(f"bt-controller: {printable(line)}", file=sys.stderr)
    draw(args, trees, statuses=False)
    if args.dot == "-":
        return DONE
    if args.json:
        keys = ("depth", "symbol", "kind", "name")
        plain = {name: [{key: getattr(node, key) for key in keys} for node in nodes] for name, nodes in trees.items()}
        shown = {"nodes": next(iter(plain.values()))} if len(trees) == 1 else {"robots": plain}
        print(json.dumps({"tree": args.tree, **shown}))
        return DONE
    for name, nodes in trees.items():
        if len(trees) > 1:
            print(f"{name}:")
        for node in nodes:
            print(node.line(status=False))
    return DONE


def _trees(name: str, plan: Plan, robots: Sequence[str]) -> dict[str, tuple[Node, ...]]:
    """Return the tree by its name or, if the trees of the robots differ, each tree by the robot's name."""
    if plan.takes_robots or len(robots) < 2:  # noqa: PLR2004 - a single tree can't differ from others
        return {name: _built(plan, robots)}
    trees = {}
    for robot in robots:
        try:
            trees[robot] = _built(plan, [robot])
        except TreeError as error:
            raise TreeError(f"{error} (for {robot!r})") from None
    first, *others = trees.values()
    return trees if any(other != first for other in others) else {name: first}


def _built(plan: Plan, robots: Sequence[str]) -> tuple[Node, ...]:
    """Return the nodes of the tree for some robots; without robots, for a single one named ``robot``."""
    from bt_controller.running.mission import missions_for

    try:
        return missions_for(robots or ["robot"], plan)[0].snapshot(None).nodes
    except TreeError as error:
        if plan.takes_robots and not robots:
            raise TreeError(f"{error}; it was given one robot, others are named by --robot") from None
        raise
