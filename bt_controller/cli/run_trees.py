"""What ``bt-controller run`` does: it runs the trees, shows them and reports how they ended."""

from __future__ import annotations

import argparse
import gc
import json
import os
import sys
from dataclasses import replace
from typing import TYPE_CHECKING, Final

from bt_controller.cli._codes import DONE, FAILED
from bt_controller.cli._trees import tree_of
from bt_controller.cli._watching import (
    check_files,
    check_pictures,
    covering,
    display,
    draw,
    watching,
)
from bt_controller.core.directory import Directory, selected
from bt_controller.errors import TreeError
from bt_controller.running.clocks import STOP, Mailbox, clock_for
from bt_controller.running.interruption import on_interrupt
from bt_controller.running.mission import missions_for, prepare
from bt_controller.running.runner import Runner
from bt_controller.running.snapshot import nodes_of
from hmrsim.program.log_options import logging_to_stderr
from hmrsim.program.signals import exit_code_of
from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.wire.options import session_options

if TYPE_CHECKING:
    from bt_controller.loading.trees import Plan
    from bt_controller.running.runner import Outcome

_GRACE: Final = 3.0
"""Wall seconds for which the simulator may be unreachable, and within which canceled goals have to end."""

_SHOW_CURSOR: Final = b"\x1b[?25h"
"""The escape sequence that shows the cursor again, which the live display hides."""


def _chosen(args: argparse.Namespace, client: Client) -> list[str]:
    """Return the robots that are named, followed by those that are selected."""
    found = selected(Directory.from_info(client.info()), args.robots) if args.robots else []
    return list(dict.fromkeys([*args.robot, *found]))


def _resumed(args: argparse.Namespace, plan: Plan) -> str | None:
    """Return the name under which goals are resumed; None to start anew."""
    wanted = plan.resumable if args.resume is None else args.resume is not False
    return f"{args.name}/{args.resume or plan.name}" if wanted else None


def run(parser: argparse.ArgumentParser, args: argparse.Namespace) -> int:
    """Run the tree that the options select for each of the robots; return the exit code."""
    if not (args.robot or args.robots):
        parser.error("the following arguments are required: --robot or --robots")
    check_pictures(args)
    plan = tree_of(args)
    check_files(args, plan)
    if plan.unset:
        raise TreeError("\n".join(plan.unset))
    if args.confirm is not None:
        plan = replace(plan, confirmed=args.confirm)
    options = session_options(args, "controller")
    mailbox = Mailbox()
    with (
        display(args) as shown,
        logging_to_stderr(args),
        covering(args) as coverage,
        Client(options, clock=args.clock, name=args.name) as client,
    ):
        client.wait_for_simulator(options.timeout)
        missions = missions_for(_chosen(args, client), plan, resume=_resumed(args, plan), coverage=coverage)
        prepare(missions)
        # The trees live until the end: the garbage collector need not traverse those of a thousand robots.
        gc.freeze()
        feedback = args.period is not None or any(mission.wants_feedback for mission in missions)
        clock = clock_for(client, mailbox, feedback=feedback, grace=_GRACE)

        def give_up() -> None:
            if sys.stdout.isatty():
                os.write(sys.stdout.fileno(), _SHOW_CURSOR)
            _report(runner.give_up(), as_json=args.json)

        with watching(args, client, missions, clock, shown) as ticked:
            runner = Runner(client, missions, clock, mailbox, show=ticked, period=args.period, grace=_GRACE)
            with on_interrupt(lambda: mailbox.put(STOP), give_up) as signals:
                outcome = runner.run()
    code = _report(outcome, as_json=args.json)
    draw(args, {mission.robot: nodes_of(mission.root) for mission in missions}, statuses=True)
    return exit_code_of(signals[0]) if outcome.interrupted else code


def _report(outcome: Outcome, *, as_json: bool) -> int:
    """Report the outcome, and return the exit code of a run that no signal ended."""
    if outcome.interrupted:
        doubt = f", but those of {', '.join(outcome.left)} have not ended yet" if outcome.left else ""
        print(f"bt-controller: interrupted; the goals were canceled{doubt}", file=sys.stderr)
    if outcome.gone:
        print("bt-controller: the simulator is gone", file=sys.stderr)
    if as_json:
        print(json.dumps(outcome.to_json()), flush=True)
    elif not outcome.interrupted:
        for robot, status in outcome.statuses.items():
            ended = "skipped" if status.name == "INVALID" and not outcome.gone else status.value
            why = outcome.why(robot)
            print(f"{robot}: {ended}{f': {why}' if why else ''}")
    return DONE if outcome.succeeded else FAILED
