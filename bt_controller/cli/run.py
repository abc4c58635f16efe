"""``bt-controller run``: run a tree for each robot."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from functools import partial

from bt_controller.cli._codes import EXAMPLES, EXIT_CODES
from bt_controller.cli._tree_options import add_robot_option, add_tree_options, add_watching_options
from hmrsim.program.command_line import Later
from hmrsim.program.log_options import add_log_options
from hmrsim_zenoh.wire.options import add_session_options, seconds


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``bt-controller run``."""
    parser.description = "Run a tree for each robot until all have ended."
    parser.epilog = f"{EXAMPLES}\n\n{EXIT_CODES}"
    add_tree_options(parser)
    add_robot_option(parser, "the robots to drive; repeatable")
    parser.add_argument(
        "--robots",
        action="extend",
        nargs="+",
        default=[],
        type=partial(_checked, Later("bt_controller.core.directory", "check_selector")),
        metavar="SELECTOR",
        help="all robots of a kind, by name: all, type:TYPE, action:ACTION, component:COMPONENT; repeatable",
    )
    parser.add_argument(
        "--clock",
        choices=("auto", "realtime", "lockstep"),
        default="auto",
        help="whether simulated time waits for the trees (default: %(default)s, the simulator's clock mode)",
    )
    parser.add_argument(
        "--name",
        default="bt_controller",
        type=partial(_checked, Later("hmrsim_zenoh.client.participant", "check_name")),
        metavar="PARTICIPANT",
        help="name of the participant in lockstep (default: %(default)s)",
    )
    parser.add_argument(
        "--period",
        type=partial(seconds, what="period"),
        metavar="SIM_S",
        help="tick every SIM_S simulated seconds, in addition to events (default: 1 s, for trees that need polling)",
    )
    parser.add_argument(
        "--json", action="store_true", help="print a line of JSON for each change of a tree, and one at the end"
    )
    parser.add_argument(
        "--confirm",
        action=argparse.BooleanOptionalAction,
        help="tick once more after success (default: as the tree specifies)",
    )
    parser.add_argument(
        "--resume",
        nargs="?",
        const="",
        metavar="MISSION",
        help="resume the mission of this name of an earlier controller with the same --name: completed steps are not"
        " repeated (default MISSION: the name of the tree)",
    )
    parser.add_argument(
        "--no-resume", dest="resume", action="store_false", help="start over, even if the tree is resumable"
    )
    add_watching_options(parser)
    add_session_options(parser)
    add_log_options(parser)
    parser.set_defaults(command=partial(Later("bt_controller.cli.run_trees", "run"), parser))


def _checked(check: Callable[[str], object], text: str) -> str:
    """Return a text that passes a check; the check's ValueError becomes the option's error."""
    try:
        check(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
    return text
