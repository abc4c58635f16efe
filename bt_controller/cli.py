"""The command ``bt-controller``."""

from __future__ import annotations

import argparse
import json
import math
import os
import re
import sys
from contextlib import nullcontext
from typing import TYPE_CHECKING, Final

from hmrsim.command_line import CommandParser, autocomplete, run_program
from hmrsim.log_options import add_log_options, logging_to_stderr
from hmrsim.signals import exit_code_of
from hmrsim_zenoh.options import ENVIRONMENT, add_session_options, session_options

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from contextlib import AbstractContextManager

    from bt_controller.display import Display
    from bt_controller.runner import Outcome
    from hmrsim.command_line import Completer

# What takes its time to load (py_trees, pydantic, zenoh) is imported where it is needed: --help is quick.
# ruff: noqa: PLC0415

_DONE: Final = 0
_FAILED: Final = 1
_WRONG_USE: Final = 2
_NOBODY: Final = 3

_GRACE: Final = 3.0
"""Wall seconds for which the simulator may be out of reach, and in which canceled goals may end."""

_SHOW_CURSOR: Final = b"\x1b[?25h"
"""The live display hides it."""

_ROBOT_NAME: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")

_EXIT_CODES: Final = """\
exit codes:
  0 done; 1 a tree failed, or there is no such robot or action; 2 wrong use, or no such tree;
  3 no simulator answers; 130 Ctrl-C, 143 SIGTERM: the goals are canceled (a second one does not wait for that)"""

_RUN_EXAMPLES: Final = """\
examples:
  bt-controller run bt_controller.examples:go_to_pose --robot wall_e
  bt-controller run missions:patrol --robot wall_e eve --connect tcp/10.0.0.7:7447
  bt-controller run missions:patrol --robot wall_e --json | jq -c 'select(.robot) | [.sim_time, .status]'

TREE is MODULE:FUNCTION; modules are looked for in the current folder, too. The function takes the
robot's name or nothing, and returns the root of a py_trees tree. Each robot has a tree and a
blackboard of its own."""

_CHECK_EXAMPLES: Final = """\
examples:
  bt-controller check bt_controller.examples:go_to_pose
  bt-controller check missions:patrol && bt-controller run missions:patrol --robot wall_e
  bt-controller check missions:patrol --json | jq '.nodes | length'"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    return run_program("bt-controller", lambda: _main(argv))


def _main(argv: Sequence[str] | None) -> int:
    parser = _parser()
    autocomplete(parser, _completers)
    args = parser.parse_args(argv)
    try:
        code: int = args.command(args)
    except BrokenPipeError:
        # Whoever read our output has gone before the end; Python would complain once more on its way out.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return _FAILED
    except Exception as error:
        if (known := _exit_code(error)) is None:
            raise
        print(f"bt-controller: {error}", file=sys.stderr)
        return known
    return code


def _completers() -> Mapping[str, Completer]:
    from hmrsim_zenoh.completion import robots

    return {"bt-controller run NAME": robots}


def _exit_code(error: Exception) -> int | None:
    """Return the exit code of an error whose text is fit to be shown; None for a bug."""
    from bt_controller.trees import TreeError
    from hmrsim.errors import HmrsimError
    from hmrsim_zenoh.errors import BadOptions, NobodyThere, PortTaken, RequestTimeout, SimulatorGone, Unreachable

    if isinstance(error, (TreeError, BadOptions, PortTaken)):
        return _WRONG_USE
    if isinstance(error, (NobodyThere, SimulatorGone, Unreachable, RequestTimeout)):
        return _NOBODY
    return _FAILED if isinstance(error, HmrsimError) else None


def _parser() -> argparse.ArgumentParser:
    parser = CommandParser(
        prog="bt-controller",
        description="Drive robots with behaviour trees, as a client of a simulator.",
        epilog=f"{_RUN_EXAMPLES}\n\n{_EXIT_CODES}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")

    run = commands.add_parser(
        "run",
        help="run a tree for each robot",
        description="Run a tree for each robot until all have ended.",
        epilog=f"{_RUN_EXAMPLES}\n\n{ENVIRONMENT}\n\n{_EXIT_CODES}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    run.add_argument("tree", metavar="TREE", help="MODULE:FUNCTION")
    run.add_argument(
        "--robot",
        action="extend",
        nargs="+",
        required=True,
        type=_robot,
        metavar="NAME",
        help="the robots to drive; repeatable",
    )
    run.add_argument(
        "--clock",
        choices=("auto", "realtime", "lockstep"),
        default="auto",
        help="whether simulated time waits for the trees (default: %(default)s, as the simulator has it)",
    )
    run.add_argument(
        "--name",
        default="bt_controller",
        type=_participant,
        metavar="PARTICIPANT",
        help="as whom to take part in lockstep (default: %(default)s)",
    )
    run.add_argument(
        "--period",
        type=_period,
        metavar="SIM_S",
        help="tick each SIM_S simulated seconds, besides when something happened"
        " (default: where a tree needs it, each 1 s)",
    )
    run.add_argument(
        "--json", action="store_true", help="one line of JSON whenever a tree has changed, and one at the end"
    )
    run.add_argument(
        "--confirm",
        action=argparse.BooleanOptionalAction,
        help="tick once more after success; otherwise as the tree has it",
    )
    add_session_options(run)
    add_log_options(run)
    run.set_defaults(command=_run)

    check = commands.add_parser(
        "check",
        help="load and check a tree without running it",
        description="Load a tree, build it and print it; nothing is sent.",
        epilog=f"{_CHECK_EXAMPLES}\n\n{_EXIT_CODES}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    check.add_argument("tree", metavar="TREE", help="MODULE:FUNCTION")
    check.add_argument("--json", action="store_true", help="print the tree as one JSON object")
    check.set_defaults(command=_check)
    return parser


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


def _check(args: argparse.Namespace) -> int:
    from bt_controller.mission import Mission
    from bt_controller.trees import load

    nodes = Mission("robot", load(args.tree)).snapshot(None).nodes
    if args.json:
        wanted = ("depth", "symbol", "kind", "name")
        print(json.dumps({"tree": args.tree, "nodes": [{key: getattr(node, key) for key in wanted} for node in nodes]}))
        return _DONE
    for node in nodes:
        print(node.line(status=False))
    return _DONE


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
    return _DONE if outcome.succeeded else _FAILED
