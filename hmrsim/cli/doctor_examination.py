"""What ``hmrsim doctor`` does: it looks at the network, and tells what is wrong with it."""

from __future__ import annotations

import argparse
import os
from collections.abc import Mapping

from hmrsim.cli.connection import VIEWER
from hmrsim.cli.doctor_text import as_json, as_text
from hmrsim.cli.exits import ExitCode
from hmrsim.cli.output import show, show_json
from hmrsim.program.log_options import logging_to_stderr
from hmrsim.settings.arguments import reader_of
from hmrsim_zenoh.doctor import Problem, asked_for, gather, problems
from hmrsim_zenoh.errors import ConnectionDenied, SimulatorNotFound
from hmrsim_zenoh.settings import ROS_DOMAIN_ID, Ros2Settings, domain_id
from hmrsim_zenoh.wire.options import session_options

ros_domain_id = reader_of(Ros2Settings, "ros_domain_id")
"""Reads the value of ``--ros-domain-id``."""


def examine(args: argparse.Namespace) -> int:
    """Look at the network and judge what is there; return the exit code."""
    given, options = args.ros_domain_id, session_options(args, VIEWER)
    asked = asked_for(
        options,
        domain=given if given is not None else _domain_of(os.environ),
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
