"""Options, exit codes and help texts that several commands of ``bt-controller`` share."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from bt_controller.errors import TreeError
from hmrsim.errors import HmrsimError, OutputError, printable

if TYPE_CHECKING:
    from bt_controller.loading.trees import Plan
    from hmrsim.program.command_line import Completer


DONE: Final = 0
FAILED: Final = 1
WRONG_USE: Final = 2
NO_SIMULATOR: Final = 3

EXIT_CODES: Final = """\
exit codes:
  0 done; 1 a tree failed, or there is no such robot or action; 2 wrong use, no such tree, or the name of
  the participant is in use; 3 no simulator answers; 130 Ctrl-C, 143 SIGTERM: the goals are canceled (a second
  one does not wait for that)"""

EXAMPLES: Final = """\
examples:
  bt-controller run bt_controller.examples:go_to_pose --robot mocha
  bt-controller run navigate.xml --robot mocha --set goal=kitchen
  bt-controller run missions:patrol --robot mocha latte --connect tcp/10.0.0.7:7447
  bt-controller run missions:patrol --robot mocha latte --secure keys --role nurses
  bt-controller run missions:patrol --robot mocha --json | jq -c 'select(.robot) | [.sim_time, .status]'

TREE is an XML file of BehaviorTree.CPP version 4 with the nodes that `bt-controller nodes` lists, or
MODULE:FUNCTION or FILE.py:FUNCTION; modules are searched in the current folder, too. The function takes the
robot's name or nothing, and returns the root of a py_trees tree; what else it takes is given by name:
'missions.py:deliver(code=7)'. Each robot has its own tree and blackboard."""


def exit_code(error: Exception) -> int | None:
    """Return the exit code of an error with a user-readable text; None for a bug."""
    from bt_controller.core.node import PortError
    from bt_controller.coverage import CoverageError
    from hmrsim_zenoh.errors import (
        BadOptions,
        ConnectionDenied,
        NameTaken,
        PortTaken,
        RequestTimeout,
        SimulationEnded,
        SimulatorGone,
        SimulatorNotFound,
        Unreachable,
    )

    if isinstance(error, (TreeError, PortError, CoverageError, BadOptions, OutputError, PortTaken, NameTaken)):
        return WRONG_USE
    if isinstance(error, (ConnectionDenied, SimulationEnded)):
        return FAILED
    if isinstance(error, (SimulatorNotFound, SimulatorGone, Unreachable, RequestTimeout)):
        return NO_SIMULATOR
    return FAILED if isinstance(error, HmrsimError) else None


_ROBOT_NAME: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_KEY: Final = re.compile(r"[\w-]+(/[\w-]+)*")


def add_tree_options(parser: Any) -> None:
    """Add the argument TREE, and the options of a tree."""
    parser.add_argument("tree", metavar="TREE", help="FILE.xml, MODULE:FUNCTION or FILE.py:FUNCTION(NAME=VALUE, …)")
    parser.add_argument(
        "--tree", dest="tree_id", metavar="ID", help="the tree of FILE.xml to run (default: its main tree)"
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
        help="write a text to each robot's blackboard before the first tick; ports parse it as in a file; repeatable",
    )


def add_robot_option(parser: Any, about: str) -> None:
    """Add the option ``--robot``, with its help."""
    parser.add_argument("--robot", action="extend", nargs="+", default=[], type=_robot, metavar="NAME", help=about)


def _robot(text: str) -> str:
    if not _ROBOT_NAME.fullmatch(text):
        expected = "selectors are for --robots" if ":" in text else "expected letters, digits and underscores"
        raise argparse.ArgumentTypeError(f"{text!r} is not a robot's name; {expected}")
    return text


def add_picture_options(parser: argparse.ArgumentParser, *, when: str = "") -> None:
    """Add the options that draw trees to a command."""
    parser.add_argument("--dot", metavar="FILE", help=f"write a picture for Graphviz{when}; - for stdout")
    parser.add_argument("--svg", metavar="FILE", help=f"write a picture as SVG{when}, drawn by Graphviz's dot")


def add_watching_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that show running trees to a command."""
    parser.add_argument("--quiet", action="store_true", help="show only the final status of each tree")
    parser.add_argument(
        "--transitions", metavar="FILE", help="write a line of JSON for each change of a behavior's status"
    )
    parser.add_argument(
        "--coverage",
        type=Path,
        metavar="FILE",
        help="count what happens to the nodes, for `bt-controller coverage`: FILE.json, with what is in it already, or"
        " FILE.info for LCOV's tracefile",
    )
    add_picture_options(parser, when=" of the final trees")


def _value(text: str) -> tuple[str, str]:
    key, equals, value = text.partition("=")
    if not (equals and _KEY.fullmatch(key)):
        raise argparse.ArgumentTypeError(f"{text!r} is not KEY=VALUE, such as goal=kitchen")
    return key, value


def tree_of(args: argparse.Namespace) -> Plan:
    """Load the tree that the options select, and print its warnings to stderr.

    Raises:
        TreeError: There is no such tree, or it is invalid.
    """
    from bt_controller.core.ports import Given
    from bt_controller.loading.trees import load

    values = {key: Given(text, key) for key, text in args.values}
    plan = load(args.tree, tree=args.tree_id, nodes=args.nodes, values=values)
    for line in plan.doubts:
        print(f"bt-controller: warning: {printable(line)}", file=sys.stderr)
    return plan


def _robots(parsed_args: argparse.Namespace, **_unused: object) -> list[str]:
    from hmrsim_zenoh.client.completion import robots

    return robots(parsed_args)


def _selectors(parsed_args: argparse.Namespace, **_unused: object) -> list[str]:
    from bt_controller.core.robots import Directory, completions
    from hmrsim_zenoh.client.completion import running

    return completions(Directory.from_info(running(parsed_args)))


COMPLETERS: Final[Mapping[str, Completer]] = {
    "bt-controller run NAME": _robots,
    "bt-controller run SELECTOR": _selectors,
}
"""Shell completion with names of the running simulator."""
