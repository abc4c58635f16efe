"""The tree that the options select."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING

from bt_controller.core.ports import Given
from bt_controller.loading.trees import load
from hmrsim.errors import printable

if TYPE_CHECKING:
    from bt_controller.loading.trees import Plan


def tree_of(args: argparse.Namespace) -> Plan:
    """Return the tree that the options select; its warnings go to stderr.

    Raises:
        TreeError: There is no such tree, or it is invalid.
    """
    values = {key: Given(text, key) for key, text in args.values}
    plan = load(args.tree, tree=args.tree_id, nodes=args.nodes, values=values)
    for line in plan.doubts:
        print(f"bt-controller: warning: {printable(line)}", file=sys.stderr)
    return plan
