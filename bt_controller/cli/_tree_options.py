"""The options that select a tree, its nodes and its values."""

from __future__ import annotations

import argparse
import re
import sys
from typing import TYPE_CHECKING, Any, Final

from bt_controller.core.ports import Given
from bt_controller.loading.trees import load

if TYPE_CHECKING:
    from bt_controller.loading.trees import Plan

_KEY: Final = re.compile(r"[\w-]+(/[\w-]+)*")


def add_tree_options(parser: Any) -> None:
    """Add TREE and its options."""
    parser.add_argument("tree", metavar="TREE", help="FILE.xml or MODULE:FUNCTION")
    parser.add_argument(
        "--tree", dest="tree_id", metavar="ID", help="which of the trees of FILE.xml (default: its own)"
    )
    parser.add_argument(
        "--nodes",
        action="extend",
        nargs="+",
        default=[],
        metavar="MODULE",
        help="modules with further nodes for FILE.xml: each public subclass of"
        " bt_controller.core.node.Node, by its name",
    )
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        dest="values",
        type=_value,
        metavar="KEY=VALUE",
        help="put a text on each robot's blackboard before the first tick; ports read it as they would in a file;"
        " repeatable",
    )


def tree_of(args: argparse.Namespace) -> Plan:
    """Return the tree that the options select; its warnings go to stderr.

    Raises:
        TreeError: There is no such tree, or it is invalid.
    """
    values = {key: Given(text, key) for key, text in args.values}
    plan = load(args.tree, tree=args.tree_id, nodes=args.nodes, values=values)
    for line in plan.doubts:
        print(f"bt-controller: warning: {line}", file=sys.stderr)
    return plan


def _value(text: str) -> tuple[str, str]:
    key, equals, value = text.partition("=")
    if not (equals and _KEY.fullmatch(key)):
        raise argparse.ArgumentTypeError(f"{text!r} is no KEY=VALUE, such as goal=kitchen")
    return key, value
