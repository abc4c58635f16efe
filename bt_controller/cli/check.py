"""``bt-controller check``: load and check a tree without running it."""

from __future__ import annotations

import argparse
from typing import Final

from bt_controller.cli._codes import EXIT_CODES
from bt_controller.cli._tree_options import add_picture_options, add_robot_option, add_tree_options
from hmrsim.program.command_line import Later

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
        "Load a tree, build it and print it; nothing is sent. Each mistake in a file is reported on its own line,"
        " and so are values that have to be given with --set, which are not mistakes."
    )
    parser.epilog = f"{_EXAMPLES}\n\n{EXIT_CODES}"
    add_tree_options(parser)
    add_robot_option(parser, "the robots that the tree is built for, where it is one for several (default: robot)")
    parser.add_argument("--json", action="store_true", help="print the tree as one JSON object")
    add_picture_options(parser)
    parser.set_defaults(command=Later("bt_controller.cli.check_tree", "check"))
