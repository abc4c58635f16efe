"""``bt-controller run``: run a tree for each robot."""

from __future__ import annotations

import argparse
import json
import math
import os
import re
import sys
from contextlib import nullcontext
from typing import TYPE_CHECKING, Any, Final

from bt_controller.cli._codes import DONE, EXIT_CODES, FAILED
from hmrsim.log_options import add_log_options, logging_to_stderr
from hmrsim.signals import exit_code_of
from hmrsim_zenoh.options import ENVIRONMENT, add_session_options, session_options

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    from bt_controller.display import Display
    from bt_controller.runner import Outcome

# What takes its time to load (py_trees, pydantic, zenoh) is imported where it is needed: --help is quick.
# ruff: noqa: PLC0415

_GRACE: Final = 3.0
"""Wall seconds for which the simulator may be out of reach, and in which canceled goals may end."""

_SHOW_CURSOR: Final = b"\x1b[?25h"
"""The live display hides it."""

_ROBOT_NAME: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")

EXAMPLES: Final = """\
examples:
  bt-controller run bt_controller.examples:go_to_pose --robot wall_e
  bt-controller run missions:patrol --robot wall_e eve --connect tcp/10.0.0.7:7447
  bt-controller run missions:patrol --robot wall_e --json | jq -c 'select(.robot) | [.sim_time, .status]'

TREE is MODULE:FUNCTION; modules are looked for in the current folder, too. The function takes the
robot's name or nothing, and returns the root of a py_trees tree. Each robot has a tree and a
blackboard of its own."""


def add_parser(commands: Any) -> None:
    """Add the command."""
    parser = commands.add_parser(
        "run",
        help="run a tree for each robot",
        description="Run a tree for each robot until all have ended.",
        epilog=f"{EXAMPLES}\n\n{ENVIRONMENT}\n\n{EXIT_CODES}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("tree", metavar="TREE", help="MODULE:FUNCTION")
    parser.add_argument(
        "--robot",
        action="extend",
        nargs="+",
        required=True,
        type=_robot,
        metavar="NAME",
        help="the robots to drive; repeatable",
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
        type=_participant,
        metavar="PARTICIPANT",
        help="as whom to take part in lockstep (default: %(default)s)",
    )
    parser.add_argument(
        "--period",
        type=_period,
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
    add_session_options(parser)
    add_log_options(parser)
    parser.set_defaults(command=_run)


def _participant(text: str) -> str:
    from hmrsim_zenoh.participant import check_name

    try:
        check_name(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
    return text


def _robot(text: str) -> str:
    if not _ROBOT_NAME.fullmatch(text):
        raise argparse.ArgumentTypeError(f"{text!r} is no robot's name; letters, digits and underscores are expected")
    return text


def _period(text: str) -> float:
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if not (seconds > 0 and math.isfinite(seconds)):
        raise argparse.ArgumentTypeError(f"{text!r} is no period; a number of seconds greater than 0 is expected")
    return seconds


def _run(args: argparse.Namespace) -> int:
    from dataclasses import replace

    from bt_controller.clocks import clock_for
    from bt_controller.interruption import on_interrupt
    from bt_controller.mailbox import STOP, Mailbox
    from bt_controller.mission import Mission
    from bt_controller.runner import Runner
    from bt_controller.trees import load
    from hmrsim_zenoh.client import Client

    plan = load(args.tree)
    if args.confirm is not None:
        plan = replace(plan, confirmed=args.confirm)
    missions = [Mission(robot, plan) for robot in dict.fromkeys(args.robot)]
    options = session_options(args)
    mailbox = Mailbox()
    entered, display = _display(as_json=args.json)
    with logging_to_stderr(args), Client(options, clock=args.clock, name=args.name) as client:
        for mission in missions:
            mission.prepare()
        client.wait_for_simulator(options.timeout)
        clock = clock_for(client, mailbox, feedback=args.period is not None, grace=_GRACE)
        runner = Runner(client, missions, clock, mailbox, show=display.show, period=args.period, grace=_GRACE)

        def give_up() -> None:
            if sys.stdout.isatty():
                os.write(sys.stdout.fileno(), _SHOW_CURSOR)
            _report(runner.give_up(), as_json=args.json)

        with entered, on_interrupt(lambda: mailbox.put(STOP), give_up) as signals:
            outcome = runner.run()
    code = _report(outcome, as_json=args.json)
    return exit_code_of(signals[0]) if outcome.interrupted else code


def _display(*, as_json: bool) -> tuple[AbstractContextManager[object], Display]:
    from bt_controller.display import JsonDisplay, PlainDisplay, live_display

    if as_json:
        return nullcontext(), JsonDisplay(sys.stdout)
    if sys.stdout.isatty():
        return live_display()
    return nullcontext(), PlainDisplay(sys.stdout)


def _report(outcome: Outcome, *, as_json: bool) -> int:
    """Say how it ended, and return the exit code of an end that no signal brought."""
    if outcome.interrupted:
        doubt = f", but those of {', '.join(outcome.left)} have not ended yet" if outcome.left else ""
        print(f"bt-controller: interrupted; the goals were canceled{doubt}", file=sys.stderr)
    if outcome.gone:
        print("bt-controller: the simulator is gone", file=sys.stderr)
    if as_json:
        print(json.dumps(outcome.to_json()), flush=True)
    elif not outcome.interrupted:
        for robot, status in outcome.statuses.items():
            print(f"{robot}: {status.value}")
    return DONE if outcome.succeeded else FAILED
