"""``hmrsim doctor``: the network: what is on it, what is wrong, and what to do."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Final

from hmrsim.cli.connection import add_connection_options
from hmrsim.cli.doctor_text import as_json, as_text
from hmrsim.cli.exits import ExitCode
from hmrsim.cli.output import show, show_json
from hmrsim.program.log_options import logging_to_stderr
from hmrsim.settings.arguments import reader_of
from hmrsim_zenoh.doctor import Problem, asked_for, gather, problems
from hmrsim_zenoh.errors import NobodyThere
from hmrsim_zenoh.settings import ROS_DOMAIN_ID, Ros2Settings, domain_id
from hmrsim_zenoh.wire.options import ENVIRONMENT, session_options

if TYPE_CHECKING:
    import argparse
    from collections.abc import Mapping

_EXAMPLES: Final = f"""\
exit codes:
  0  no errors, maybe warnings
  1  errors; each comes with a remedy
  2  wrong use
  3  neither a simulator nor a ROS node answers

examples:
  hmrsim doctor
  hmrsim doctor --ros-domain-id 7 --connect tcp/10.0.0.7:7447
  hmrsim doctor --json | jq -r '.problems[].remedy'

{ENVIRONMENT}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim doctor``."""
    parser.description = (
        "Show what is on the network (a simulator, its robots and their controllers, ROS nodes), what is wrong,\n"
        "and what to do. It observes for half a second, and changes nothing."
    )
    parser.epilog = _EXAMPLES
    parser.add_argument("--json", action="store_true", help="print one JSON object with everything")
    parser.add_argument(
        "--ros-domain-id",
        type=reader_of(Ros2Settings, "ros_domain_id"),
        metavar="N",
        help=f"the ROS domain to examine (default: the environment's {ROS_DOMAIN_ID}, else 0)",
    )
    parser.set_defaults(function=_examine)
    add_connection_options(parser)


def _examine(args: argparse.Namespace) -> int:
    given, options = args.ros_domain_id, session_options(args)
    asked = asked_for(
        options,
        domain=given if given is not None else _domain_of(os.environ),
        environment=os.environ,
        wants_ros=given is not None,
    )
    try:
        with logging_to_stderr(args):
            snapshot = gather(options, asked)
    except NobodyThere as error:
        if args.json:
            text, _, remedy = str(error).partition("; ")
            show_json(as_json(asked, [Problem("nobody_there", text, remedy)]))
        raise
    found = problems(snapshot)
    if args.json:
        show_json(as_json(snapshot, found))
    else:
        show(as_text(snapshot, found))
    return ExitCode.FAILED if any(one.severity == "error" for one in found) else ExitCode.DONE


def _domain_of(environment: Mapping[str, str]) -> int:
    """Return the domain of the environment; 0 if it has none, or an invalid one, which is reported as a problem."""
    try:
        return domain_id(environment.get(ROS_DOMAIN_ID, ""))
    except ValueError:
        return 0
