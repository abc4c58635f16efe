"""``hmrsim doctor``: diagnose a network: what is on it, what is wrong, and what to do."""

from __future__ import annotations

import argparse
import os

from hmrsim.cli.connection import VIEWER
from hmrsim.cli.exits import ExitCode
from hmrsim.cli.options import add_connection_options, add_json, ros_domain_of_environment
from hmrsim.cli.output import show_json, show_result
from hmrsim.program.command_line import Later
from hmrsim.program.log_options import logging_to_stderr
from hmrsim_zenoh.errors import BadOptions, ConnectionDenied, SimulatorNotFound
from hmrsim_zenoh.wire.options import session_options


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim doctor``."""
    parser.description = (
        "Show what is on the network (a simulator, its robots and their controllers, ROS nodes), what is wrong,\n"
        "and what to do. It observes for half a second, and changes nothing."
    )
    parser.epilog = """\
exit codes:
  0  no errors, maybe warnings
  1  errors; each comes with a remedy
  2  wrong use
  3  neither a simulator nor a ROS node answers

examples:
  hmrsim doctor
  hmrsim doctor --ros-domain-id 7 --connect tcp/10.0.0.7:7447
  hmrsim doctor --json | jq -r '.problems[].remedy'"""
    add_json(parser, "print one JSON object with everything")
    parser.add_argument(
        "--ros-domain-id",
        type=Later("hmrsim.cli.doctor_text", "ros_domain_id"),
        metavar="N",
        help="the ROS domain to examine (default: the environment's ROS_DOMAIN_ID, else 0)",
    )
    parser.set_defaults(function=_examine)
    add_connection_options(parser)


def _examine(args: argparse.Namespace) -> int:
    from hmrsim.cli.doctor_text import as_json, as_text
    from hmrsim_zenoh.doctor import Problem, gather, problems, requested

    given, options = args.ros_domain_id, session_options(args, VIEWER)
    asked = requested(
        options,
        domain=given if given is not None else _domain_of_environment(),
        environment=os.environ,
        wants_ros=given is not None,
    )
    try:
        with logging_to_stderr(args):
            snapshot = gather(options, asked)
    except SimulatorNotFound as error:
        if args.json:
            text, _, remedy = str(error).partition("; ")
            kind = "access_denied" if isinstance(error, ConnectionDenied) else "nobody_there"
            show_json(as_json(asked, [Problem(kind, text, remedy)]))
        raise
    found = problems(snapshot)
    show_result(as_json(snapshot, found), as_text(snapshot, found), as_json=args.json)
    return ExitCode.FAILED if any(problem.severity == "error" for problem in found) else ExitCode.DONE


def _domain_of_environment() -> int:
    """Return the ROS domain of the environment; 0 if it is not valid, which is reported as a problem."""
    try:
        return ros_domain_of_environment()
    except BadOptions:
        return 0
