"""``bt-controller run``: run a tree for each robot.

Ctrl-C and SIGTERM stop it, also while a behavior does not return.
"""

from __future__ import annotations

import argparse
import gc
import json
import os
import queue
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Final

from bt_controller.cli._options import (
    DONE,
    EXAMPLES,
    EXIT_CODES,
    FAILED,
    add_robot_option,
    add_tree_options,
    add_watching_options,
    tree_of,
)
from bt_controller.errors import TreeError
from hmrsim.program.command_line import Later
from hmrsim.program.log_options import add_log_options, logging_to_stderr
from hmrsim.program.signals import exit_code_of, on_signals
from hmrsim_zenoh.wire.options import add_session_options, seconds

if TYPE_CHECKING:
    from bt_controller.loading.trees import Plan
    from bt_controller.running.runner import Outcome
    from hmrsim_zenoh.client.client import Client


_STOP_SECONDS: Final = 4.0
"""Wall seconds for a regular stop: longer than the grace period of canceled goals."""

_OVER: Final = 0
"""Ends the watch; no signal has this number."""


@contextmanager
def on_interrupt(stop: Callable[[], None], give_up: Callable[[], None]) -> Iterator[list[int]]:
    """Stop regularly on the first SIGINT or SIGTERM, and end the process on the second or after a time limit.

    A separate thread receives the signals, since the main thread may be in a behavior that blocks, even in C.
    Yields the list of the signals' numbers so far. Use it in the main thread only.

    Args:
        stop: Requests a regular stop; called at the first signal.
        give_up: Cleans up without the main thread; the process ends afterwards.
    """
    numbers: list[int] = []
    heard: queue.SimpleQueue[int] = queue.SimpleQueue()
    with on_signals(heard.put):
        watch = threading.Thread(target=_watch, args=(heard, numbers, stop, give_up), daemon=True)
        watch.start()
        try:
            yield numbers
        finally:
            heard.put(_OVER)
            watch.join()


def _watch(
    heard: queue.SimpleQueue[int], numbers: list[int], stop: Callable[[], None], give_up: Callable[[], None]
) -> None:
    first = heard.get()
    if first == _OVER:
        return
    numbers.append(first)
    stop()
    with suppress(queue.Empty):
        if heard.get(timeout=_STOP_SECONDS) == _OVER:
            return
    # Whatever happens now must not keep the process alive.
    with suppress(Exception):
        give_up()
    os._exit(exit_code_of(first))


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
        type=partial(_checked, Later("bt_controller.core.robots", "check_selector")),
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
        type=partial(_checked, Later("hmrsim_zenoh.client.lockstep", "check_name")),
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
    parser.add_argument(
        "--groot2",
        nargs="?",
        type=int,
        const=1667,
        metavar="PORT",
        help="serve the running tree to Groot2 and `btview` on this machine (default PORT: 1667); the trees of further"
        " robots at PORT + 2, PORT + 4, …; needs hmrsim[groot2]",
    )
    add_watching_options(parser)
    add_session_options(parser)
    add_log_options(parser)
    parser.set_defaults(function=partial(_run, parser))


def _checked(check: Callable[[str], object], text: str) -> str:
    """Return a text that passes a check; the check's ValueError becomes the option's error."""
    try:
        check(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
    return text


_GRACE: Final = 3.0
"""Wall seconds for which the simulator may be unreachable, and within which canceled goals have to end."""

_SHOW_CURSOR: Final = b"\x1b[?25h"
"""The escape sequence that shows the cursor again, which the live display hides."""


def _chosen(args: argparse.Namespace, client: Client) -> list[str]:
    """Return the robots that are named, followed by those that are selected."""
    from bt_controller.core.robots import Directory, selected

    found = selected(Directory.from_info(client.info()), args.robots) if args.robots else []
    return list(dict.fromkeys([*args.robot, *found]))


def _resumed(args: argparse.Namespace, plan: Plan) -> str | None:
    """Return the name under which goals are resumed; None to start anew."""
    wanted = plan.resumable if args.resume is None else args.resume is not False
    return f"{args.name}/{args.resume or plan.name}" if wanted else None


def _run(parser: argparse.ArgumentParser, args: argparse.Namespace) -> int:
    from bt_controller.cli._watching import check_files, check_pictures, covering, display, draw, watching
    from bt_controller.running.clocks import STOP, Mailbox, clock_for
    from bt_controller.running.mission import missions_for, prepare
    from bt_controller.running.runner import Runner
    from bt_controller.running.snapshot import nodes_of
    from hmrsim_zenoh.client.client import Client
    from hmrsim_zenoh.wire.options import session_options

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
            _report(runner.give_up(), options.prefix, as_json=args.json)

        with watching(args, client, missions, clock, shown) as ticked:
            runner = Runner(client, missions, clock, mailbox, show=ticked, period=args.period, grace=_GRACE)
            with on_interrupt(lambda: mailbox.put(STOP), give_up) as signals:
                outcome = runner.run()
    code = _report(outcome, options.prefix, as_json=args.json)
    draw(args, {mission.robot: nodes_of(mission.root) for mission in missions}, statuses=True)
    return exit_code_of(signals[0]) if outcome.interrupted else code


def _report(outcome: Outcome, prefix: str, *, as_json: bool) -> int:
    """Report the outcome, and return the exit code of a run that no signal ended."""
    if outcome.interrupted:
        doubt = f", but those of {', '.join(outcome.left)} have not ended yet" if outcome.left else ""
        print(f"bt-controller: interrupted; the goals were canceled{doubt}", file=sys.stderr)
    if outcome.gone:
        remedy = "start it again, or look in its output for why it has ended"
        print(f"bt-controller: the simulator {prefix!r} is gone; {remedy}", file=sys.stderr)
    if as_json:
        print(json.dumps(outcome.to_json()), flush=True)
    elif not outcome.interrupted:
        for robot, status in outcome.statuses.items():
            ended = "skipped" if status.name == "INVALID" and not outcome.gone else status.value
            why = outcome.why(robot)
            print(f"{robot}: {ended}{f': {why}' if why else ''}")
    return DONE if outcome.succeeded else FAILED
