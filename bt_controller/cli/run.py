"""``bt-controller run``: run a tree for each robot."""

from __future__ import annotations

import argparse
import re
from functools import partial
from typing import TYPE_CHECKING, Final

from bt_controller.cli._codes import EXAMPLES, EXIT_CODES
from bt_controller.cli._tree_options import add_tree_options, add_watching_options
from hmrsim.program.command_line import Later
from hmrsim.program.log_options import add_log_options
from hmrsim_zenoh.wire.options import ENVIRONMENT, add_session_options, seconds

if TYPE_CHECKING:
    from collections.abc import Callable

_ROBOT_NAME: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``bt-controller run``."""
    parser.description = "Run a tree for each robot until all have ended."
    parser.epilog = f"{EXAMPLES}\n\n{ENVIRONMENT}\n\n{EXIT_CODES}"
    add_tree_options(parser)
    parser.add_argument(
        "--robot",
        action="extend",
        nargs="+",
        default=[],
        type=_robot,
        metavar="NAME",
        help="the robots to drive; repeatable",
    )
    parser.add_argument(
        "--robots",
        action="extend",
        nargs="+",
        default=[],
        type=partial(_checked, Later("bt_controller.running.selection", "check_selector")),
        metavar="SELECTOR",
        help="all robots of a kind, by name: all, type:TYPE, action:ACTION, component:COMPONENT; repeatable",
    )
    parser.add_argument(
        "--clock",
        choices=("auto", "realtime", "lockstep"),
        default="auto",
        help="whether simulated time waits for the trees (default: %(default)s, as the simulator has it)",
    )
    parser.add_argument(
        "--name",
        default="bt_controller",
        type=partial(_checked, Later("hmrsim_zenoh.client.participant", "check_name")),
        metavar="PARTICIPANT",
        help="as whom to take part in lockstep (default: %(default)s)",
    )
    parser.add_argument(
        "--period",
        type=partial(seconds, what="period"),
        metavar="SIM_S",
        help="tick each SIM_S simulated seconds, besides when something happened"
        " (default: where a tree needs it, each 1 s)",
    )
    parser.add_argument(
        "--json", action="store_true", help="one line of JSON whenever a tree has changed, and one at the end"
    )
    parser.add_argument(
        "--confirm",
        action=argparse.BooleanOptionalAction,
        help="tick once more after success; otherwise as the tree has it",
    )
    parser.add_argument(
        "--resume",
        nargs="?",
        const="",
        metavar="MISSION",
        help="go on where a controller of the same --name ended with a mission of this name: no step that it did is"
        " done again (default: the name of the tree, where no MISSION is given)",
    )
    parser.add_argument(
        "--no-resume", dest="resume", action="store_false", help="begin anew, also where the tree would go on"
    )
    add_watching_options(parser)
    add_session_options(parser)
    add_log_options(parser)
    parser.set_defaults(command=partial(Later("bt_controller.cli.run_trees", "run"), parser))


def _robot(text: str) -> str:
    if not _ROBOT_NAME.fullmatch(text):
        raise argparse.ArgumentTypeError(f"{text!r} is no robot's name; letters, digits and underscores are expected")
    return text


def _checked(check: Callable[[str], object], text: str) -> str:
    """Return a text that passes a check; the check's ValueError becomes the option's error."""
    try:
        check(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
    return text
