"""``bt-controller run``: run a tree for each robot."""

from __future__ import annotations

import argparse
import gc
import json
import os
import re
import sys
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Final

from bt_controller.cli._codes import DONE, EXAMPLES, EXIT_CODES, FAILED
from bt_controller.cli._tree_options import add_tree_options, tree_of
from bt_controller.cli._watching import (
    add_watching_options,
    check_pictures,
    display,
    draw,
    in_words,
    watching,
    why_failed,
)
from bt_controller.errors import TreeError
from bt_controller.running.clocks import clock_for
from bt_controller.running.interruption import on_interrupt
from bt_controller.running.mailbox import STOP, Mailbox
from bt_controller.running.mission import missions_for, prepare
from bt_controller.running.runner import Runner
from bt_controller.running.selection import check_selector, selected
from bt_controller.running.snapshot import nodes_of
from bt_controller.world.directory import Directory
from hmrsim.program.log_options import add_log_options, logging_to_stderr
from hmrsim.program.signals import exit_code_of
from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.client.participant import check_name
from hmrsim_zenoh.wire.options import ENVIRONMENT, add_session_options, seconds, session_options

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from bt_controller.loading.trees import Plan
    from bt_controller.running.runner import Outcome

_GRACE: Final = 3.0
"""Wall seconds for which the simulator may be unreachable, and within which canceled goals have to end."""

_SHOW_CURSOR: Final = b"\x1b[?25h"
"""The live display hides it."""

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
        type=partial(_checked, check_selector),
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
        type=partial(_checked, check_name),
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
    parser.set_defaults(command=partial(_run, parser))


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


def _chosen(args: argparse.Namespace, client: Client) -> list[str]:
    """Return the robots that are named, followed by those that are selected."""
    found = selected(Directory.from_info(client.info()), args.robots) if args.robots else []
    return list(dict.fromkeys([*args.robot, *found]))


def _resumed(args: argparse.Namespace, plan: Plan) -> str | None:
    """Return the name under which goals are resumed; None to start anew."""
    wanted = plan.resumable if args.resume is None else args.resume is not False
    return f"{args.name}/{args.resume or plan.name}" if wanted else None


def _run(parser: argparse.ArgumentParser, args: argparse.Namespace) -> int:
    if not (args.robot or args.robots):
        parser.error("the following arguments are required: --robot or --robots")
    check_pictures(args)
    plan = tree_of(args)
    if plan.unset:
        raise TreeError("\n".join(plan.unset))
    if args.confirm is not None:
        plan = replace(plan, confirmed=args.confirm)
    options = session_options(args)
    mailbox = Mailbox()
    with (
        display(args) as shown,
        logging_to_stderr(args),
        Client(options, clock=args.clock, name=args.name) as client,
    ):
        client.wait_for_simulator(options.timeout)
        missions = missions_for(_chosen(args, client), plan, resume=_resumed(args, plan))
        prepare(missions)
        # The trees live until the end: the garbage collector need not traverse those of a thousand robots.
        gc.freeze()
        clock = clock_for(client, mailbox, feedback=args.period is not None, grace=_GRACE)

        def give_up() -> None:
            if sys.stdout.isatty():
                os.write(sys.stdout.fileno(), _SHOW_CURSOR)
            _report(runner.give_up(), {}, as_json=args.json)

        with watching(args, client, missions, clock, shown) as ticked:
            runner = Runner(client, missions, clock, mailbox, show=ticked, period=args.period, grace=_GRACE)
            with on_interrupt(lambda: mailbox.put(STOP), give_up) as signals:
                outcome = runner.run()
    code = _report(outcome, why_failed(missions), as_json=args.json)
    draw(args, {mission.robot: nodes_of(mission.root) for mission in missions}, statuses=True)
    return exit_code_of(signals[0]) if outcome.interrupted else code


def _report(outcome: Outcome, why: Mapping[str, Sequence[Mapping[str, str]]], *, as_json: bool) -> int:
    """Report the outcome, and return the exit code of a run that no signal ended."""
    if outcome.interrupted:
        doubt = f", but those of {', '.join(outcome.left)} have not ended yet" if outcome.left else ""
        print(f"bt-controller: interrupted; the goals were canceled{doubt}", file=sys.stderr)
    if outcome.gone:
        print("bt-controller: the simulator is gone", file=sys.stderr)
    if as_json:
        print(json.dumps({**outcome.to_json(), "reasons": why}), flush=True)
    elif not outcome.interrupted:
        for robot, status in outcome.statuses.items():
            ended = "skipped" if status.name == "INVALID" and not outcome.gone else status.value
            print(f"{robot}: {ended}{in_words(why.get(robot, ()))}")
    return DONE if outcome.succeeded else FAILED
