"""``hmrsim run``: serve a world until Ctrl-C, SIGTERM or the end of its time."""

from __future__ import annotations

import logging
import math
import shlex
import sys
import traceback
from contextlib import contextmanager
from itertools import chain
from typing import TYPE_CHECKING, Any, Final

from hmrsim.actions import registry as actions
from hmrsim.cli import numbers
from hmrsim.cli.exits import ExitCode, WrongUse
from hmrsim.cli.garbage import collect_rarely
from hmrsim.cli.goal_summary import summary
from hmrsim.cli.output import show, show_json, warn
from hmrsim.cli.problems import line_of
from hmrsim.cli.recording import add_record_option, recorded
from hmrsim.cli.ros2_options import add_ros2_options, ros2_wires
from hmrsim.cli.run_log import EventLog, Later, LogLines
from hmrsim.cli.time_options import TIME_STANDS, add_run_options, add_time_options
from hmrsim.cli.tracing import traced
from hmrsim.cli.view_options import add_view_options, check_port, viewed
from hmrsim.cli.world_options import add_world_options, read_world
from hmrsim.errors import HmrsimError, printable
from hmrsim.events import Severity
from hmrsim.program.log_options import add_log_options, log_level
from hmrsim.program.signals import on_signals
from hmrsim.protocol.time import REALTIME
from hmrsim_zenoh.host import Host, HostSettings
from hmrsim_zenoh.wire.envelopes import MAX_PAYLOAD
from hmrsim_zenoh.wire.options import ENVIRONMENT, add_session_options, session_options

if TYPE_CHECKING:
    import argparse
    from collections.abc import Callable, Iterator

    from hmrsim.cli.run_table import HostTable
    from hmrsim.cli.view_options import View
    from hmrsim.interfaces.message import Message
    from hmrsim.world_checks import LoadedWorld
    from hmrsim_zenoh.ros2.wires import Wire
    from hmrsim_zenoh.wire.session import SessionOptions

_EXAMPLES: Final = f"""\
examples:
  hmrsim run scenario1
  hmrsim run hospital --real-time-factor 10 --seed 3
  hmrsim run hospital --clock lockstep --participants nurses,porters --trace run.jsonl
  hmrsim run my_map.yaml --robot wall_e@3,4:fetcher --item medicine@9,2.3:0.2
  hmrsim run hospital --listen tcp/0.0.0.0:7447 --duration 600 --json
  hmrsim run scenario1 --view
  hmrsim run scenario1 --ros2
  hmrsim run hospital --ros2 --ros-domain-id 7 --ros-distro jazzy --ros-distro kilted

{ENVIRONMENT}"""

_LOOK: Final = 0.1
"""Wall seconds between looks: Python sees a signal only when a wait is over."""


_log = logging.getLogger(__name__)

_RATES: Final = {"feedback": 10.0, "odom": 10.0, "clock": 10.0, "detection": 10.0, "battery": 1.0}
"""What is sampled, and how often a simulated second if nothing is said."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim run``."""
    parser.description = (
        "Serve a world over Zenoh until Ctrl-C. Prints `ready ENDPOINT …` once clients can connect; a table of the\n"
        "robots (on a terminal) or a log goes to stderr."
    )
    parser.epilog = _EXAMPLES
    add_world_options(parser)
    add_run_options(parser)
    add_record_option(parser)
    add_time_options(parser)
    _add_server_options(parser)
    add_view_options(parser)
    add_ros2_options(parser)
    add_session_options(parser)
    add_log_options(parser, default="info")
    parser.add_argument("--json", action="store_true", help="say that it is ready as one JSON object")
    parser.set_defaults(function=_run)


def _add_server_options(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("server")
    for topic, rate in _RATES.items():
        group.add_argument(
            f"--{topic}-rate",
            type=numbers.positive,
            default=rate,
            metavar="HZ",
            help=f"samples of {topic} a simulated second (default: %(default)g)",
        )
    group.add_argument(
        "--result-timeout",
        type=numbers.or_for_ever,
        default=900.0,
        metavar="S",
        help="wall seconds that a result is kept; -1: for ever (default: %(default)g)",
    )
    group.add_argument(
        "--keep-results", type=numbers.count, default=1000, metavar="N", help="… and how many a robot (default: 1000)"
    )
    group.add_argument(
        "--max-payload",
        type=numbers.count,
        default=MAX_PAYLOAD,
        metavar="BYTES",
        help="refuse requests that are larger (default: %(default)s)",
    )


def _run(args: argparse.Namespace) -> int:
    options, wires = session_options(args), ros2_wires(args)
    check_port(args.view)
    if args.trace and args.record and args.trace.resolve() == args.record.resolve():
        raise WrongUse(f"--trace and --record are both {args.record}; name two files")
    loaded = read_world(args)
    for problem in loaded.warnings:
        warn(line_of(problem))
    if args.clock == REALTIME and args.real_time_factor == 0 and args.duration < math.inf:
        warn(f"--duration {args.duration:g}: as fast as possible, {TIME_STANDS}")
    host = Host(loaded, options, _settings(args, wires))
    with (
        host,
        traced(args.trace, host.simulator) as trace,
        recorded(args.record, host, clock_rate=args.clock_rate),
        _shown(host, loaded, log_level(args)) as table,
    ):
        if trace is not None:
            host.pacing.on_wait.append(trace.flush)
        with viewed(args.view, host.endpoints or options.connect, options.prefix) as view:
            _serve(host, table, lambda: _tell_ready(loaded, host, options, view, as_json=args.json))
        if isinstance(host.error, HmrsimError):
            raise host.error
    if host.error is not None:
        traceback.print_exception(host.error)
        return ExitCode.FAILED
    return ExitCode.DONE


def _serve(host: Host, table: HostTable | None, tell_ready: Callable[[], None]) -> None:
    """Run the simulation until its end or a signal."""
    signals: list[int] = []
    with on_signals(signals.append):
        collect_rarely()
        host.start()
        tell_ready()
        while not signals and not host.wait(_LOOK):
            if table is not None:
                table.refresh()
        host.stop()


def _settings(args: argparse.Namespace, wires: tuple[Wire, ...]) -> HostSettings:
    return HostSettings(
        clock=args.clock,
        real_time_factor=args.real_time_factor,
        participants=args.participants,
        participant_timeout=args.participant_timeout,
        end_on_loss=args.on_participant_loss == "end",
        planner_timeout=args.planner_timeout,
        step_size=args.step_size,
        duration=args.duration,
        seed=args.seed,
        feedback_rate=args.feedback_rate,
        odom_rate=args.odom_rate,
        clock_rate=args.clock_rate,
        battery_rate=args.battery_rate,
        detection_rate=args.detection_rate,
        result_timeout=args.result_timeout,
        keep_results=args.keep_results,
        max_payload=args.max_payload,
        wires=wires,
    )


def _tell_ready(loaded: LoadedWorld, host: Host, options: SessionOptions, view: View | None, *, as_json: bool) -> None:
    world = loaded.world
    url = view.url() if view else None
    if as_json:
        ready: dict[str, Any] = {"ready": True, "endpoints": list(host.endpoints), "prefix": options.prefix}
        ready |= {"world": {"name": world.name, "hash": loaded.hash}, "robots": list(world.robots)}
        show_json(ready | ({"view": url} if url else {}))
        return
    where = host.endpoints or options.connect
    shown = (f"view={url}",) if url else ()
    name = shlex.quote(printable(world.name))
    show(" ".join(("ready", *where, f"world={name}", f"robots={len(world.robots)}", *shown)))


def _goals() -> Iterator[type[Message]]:
    return (action.goal for action in actions().values())


@contextmanager
def _shown(host: Host, loaded: LoadedWorld, level: int) -> Iterator[HostTable | None]:
    """Show what happens on stderr: a table that wants to be refreshed on a terminal, log lines elsewhere."""
    if sys.stderr.isatty():
        # Takes its time to load, which no other simulator needs.
        from hmrsim.cli.run_table import HostTable  # noqa: PLC0415

        with HostTable(host, loaded.world.name) as table, LogLines(table.print, level):
            host.attach(table)
            host.attach(EventLog(Severity.ERROR, goals=False))
            yield table
        return
    with LogLines(level=level):
        log = Later(EventLog())
        if level <= logging.INFO:
            host.attach(log)
            host.pacing.on_wait.append(log.hand_on)
            host.pacing.preparations = chain(host.pacing.preparations, (summary(goal()) for goal in _goals()))
        _log.info("sim %.3f | %s begins", host.simulator.now, printable(loaded.world.name))
        if awaited := host.pacing.state.waiting_for:
            _log.info("sim %.3f | time stands, waiting for %s", host.simulator.now, ", ".join(awaited))
        yield None
        log.hand_on()
        _log.info("sim %.3f | %s ends", host.simulator.now, printable(loaded.world.name))
