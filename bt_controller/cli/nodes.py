"""``bt-controller nodes``: list the nodes of XML trees."""

from __future__ import annotations

import argparse
from typing import Final

from bt_controller.cli._codes import EXIT_CODES
from hmrsim.program.command_line import Later

_EXAMPLES: Final = """\
examples:
  bt-controller nodes
  bt-controller nodes RecoveryNode
  bt-controller nodes --xml > palette.xml
  bt-controller nodes --json | jq 'keys'"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``bt-controller nodes``."""
    parser.description = "List the nodes of XML trees; the named ones with their ports."
    parser.epilog = f"{_EXAMPLES}\n\n{EXIT_CODES}"
    parser.add_argument("nodes", nargs="*", metavar="NODE", help="a node's tag (default: all nodes)")
    form = parser.add_mutually_exclusive_group()
    form.add_argument("--json", action="store_true", help="one JSON object: nodes with their ports, by tag")
    form.add_argument("--xml", action="store_true", help="a TreeNodesModel, for editors such as Groot2")
    parser.set_defaults(command=Later("bt_controller.cli.node_list", "print_nodes"))
