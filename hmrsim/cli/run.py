"""``hmrsim run``: serve a world until Ctrl-C, SIGTERM or the end of its time."""

from __future__ import annotations

import argparse
import logging
import math
import os
import secrets
import shlex
import sys
import traceback
from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from hmrsim.cli.options import ExitCode, add_json, add_world_argument, ros_domain_of_environment
from hmrsim.cli.output import show_result, warn
from hmrsim.errors import HmrsimError, printable
from hmrsim.program.files import check_outputs
from hmrsim.program.log_options import ServerLogOptions, log_level
from hmrsim.program.signals import on_signals
from hmrsim.protocol.time import REALTIME
from hmrsim.settings.arguments import add_settings, read_settings
from hmrsim.settings.run import TIME_STANDS, RunSettings, TraceSettings
from hmrsim_zenoh.errors import BadOptions, ParticipantLost
from hmrsim_zenoh.settings import (
    SERVED,
    MonitorSettings,
    RecordSettings,
    Ros2Settings,
    ViewSettings,
)
from hmrsim_zenoh.wire.options import SessionOptions

if TYPE_CHECKING:
    from hmrsim.cli.event_log import LogDisplay
    from hmrsim.cli.robot_table import TableDisplay
    from hmrsim.diagnostics import Finding
    from hmrsim.program.command_line import CommandParser
    from hmrsim.properties import MonitorSink, Violation
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.timing.pacing import Watchers
    from hmrsim.world import World
    from hmrsim.world_checks import LoadedWorld
    from hmrsim_zenoh.hosting.host import Host
    from hmrsim_zenoh.ros2.wires import Wire

_MAX_WARNINGS: Final = 5
"""Maximum number of traffic warnings to print; in a large fleet, further ones have the same cause."""

_WAIT_SECONDS: Final = 0.1
"""Wall seconds of one wait: Python handles signals only between waits."""

_log = logging.getLogger(__name__)


def configure(parser: CommandParser) -> None:
    """Add the arguments of ``hmrsim run``."""
    parser.description = (
        "Serve a world over Zenoh until Ctrl-C. Prints `ready ENDPOINT …` once clients can connect; a table of the\n"
        "robots (on a terminal) or a log goes to stderr."
    )
    parser.epilog = """\
examples:
  hmrsim run scenario1
  hmrsim run hospital --real-time-factor 10 --seed 3
  hmrsim run hospital --clock lockstep --participants nurses,porters --trace run.jsonl
  hmrsim run hospital --settings lockstep.yaml --seed 3
  hmrsim run my_map.yaml --robot wall_e@3,4:fetcher --item medicine@9,2.3:0.2
  hmrsim run hospital --secure keys --listen tls/0.0.0.0:7447
  hmrsim run hospital --listen tcp/127.0.0.1:7450 --duration 600 --json
  hmrsim run scenario1 --view
  hmrsim run hospital --monitor properties.yaml
  hmrsim run scenario1 --ros2
  hmrsim run hospital --ros2 --ros-domain-id 7 --ros-distro jazzy --ros-distro kilted"""
    parser.suggest({"--port": "--listen tcp/127.0.0.1:PORT, or --view PORT for the page"})
    add_world_argument(parser)
    for model in SERVED:
        add_settings(parser, model)
    parser.add_argument(
        "--settings",
        type=Path,
        metavar="FILE",
        help="a settings file, YAML or JSON; options and environment variables override it",
    )
    add_json(parser, "print the ready message as one JSON object")
    parser.set_defaults(function=_run)


class _Resolved:
    """Run settings, merged from options, environment, settings file and defaults."""

    def __init__(self, args: argparse.Namespace) -> None:
        from hmrsim.settings.run import read_file

        self.below = read_file(args.settings, SERVED) if args.settings else {}
        read = partial(read_settings, args, below=self.below)
        self.run = read(RunSettings).model_copy(update={"run_id": secrets.token_hex(8)})
        self.session = read(SessionOptions)
        self.ros2 = read(Ros2Settings)
        self.trace = read(TraceSettings).trace
        self.record = read(RecordSettings).record
        self.monitor = read(MonitorSettings).monitor
        self.view = read(ViewSettings).view
        self.log_level = log_level(read(ServerLogOptions))


def _run(args: argparse.Namespace) -> int:
    from hmrsim import plugins
    from hmrsim.cli.replay import TraceFile
    from hmrsim.cli.view import check_page, viewed
    from hmrsim.cli.worlds import read_world, show_warnings
    from hmrsim.program.memory import Heap
    from hmrsim.world_checks.obstructions import check_obstructions
    from hmrsim_zenoh.hosting.host import Host
    from hmrsim_zenoh.wire.configuration import exposed

    settings = _Resolved(args)
    run, wires = settings.run, ros2_wires(settings.ros2)
    check_page(settings.view, settings.session)
    obstructions: list[Finding] = []

    def first_obstructions(world: World) -> list[Finding]:
        obstructions[:] = check_obstructions(world)
        return obstructions[:_MAX_WARNINGS]

    loaded = read_world(args, below=settings.below, further=[first_obstructions])
    check_outputs(
        [("--trace", settings.trace), ("--record", settings.record)],
        [*loaded.files, args.settings, settings.monitor, settings.session.zenoh_config],
    )
    show_warnings(loaded)
    if (more := len(obstructions) - _MAX_WARNINGS) > 0:
        warn(f"and {more} more traffic warnings; `hmrsim map validate --traffic WORLD` lists all")
    monitor = None if settings.monitor is None else _Monitor(settings.monitor, loaded.world)
    if run.clock == REALTIME and run.real_time_factor == 0 and run.duration < math.inf:
        warn(f"--duration {run.duration:g}: as fast as possible, {TIME_STANDS}")
    trace = TraceFile(settings.trace, loaded.world, run)
    screen = _display(loaded.world.name, settings.log_level)
    heap = Heap()
    with _recording(settings.record, run) as recording:
        host = Host(
            loaded,
            settings.session,
            run,
            wires=wires,
            sinks=[*trace.sinks, *screen.sinks],
            watchers=lambda simulator, pacing: [
                *recording(simulator, pacing),
                *([monitor.sink(simulator)] if monitor is not None else []),
            ],
            on_wait=[trace.flush, *screen.on_wait],
            preparations=screen.preparations,
        )
        for endpoint in exposed(settings.session, host.endpoints):
            warn(f"{endpoint} is open: anyone who can reach it can drive the robots; encrypt it with --secure DIR")
        with host, trace.opened(host.simulator), screen.shown(host) as refresh:
            if run.strict:
                plugins.check()
            with viewed(settings.view, host.endpoints or host.options.connect, host.options) as url:
                _serve(host, [refresh, heap.trim], lambda: _show_ready(loaded, host, url(), as_json=args.json))
            if monitor is not None:
                monitor.end(host.simulator.now)
            if isinstance(host.error, HmrsimError) and not isinstance(host.error, ParticipantLost):
                raise host.error
    if isinstance(host.error, HmrsimError):
        # The outputs of the run are complete.
        raise host.error
    if host.error is not None:
        traceback.print_exception(host.error)
        return ExitCode.FAILED
    return ExitCode.FAILED if monitor is not None and monitor.violated else ExitCode.DONE


def _display(world: str, level: int) -> TableDisplay | LogDisplay:
    """Return the display for stderr: a table of the robots on a terminal, otherwise a log."""
    if sys.stderr.isatty():
        # Loads rich, which takes 60 ms.
        from hmrsim.cli.robot_table import TableDisplay

        return TableDisplay(world, level)
    from hmrsim.cli.event_log import LogDisplay

    return LogDisplay(world, level)


def _recording(path: Path | None, settings: RunSettings) -> AbstractContextManager[Watchers]:
    """Return a context that provides the sinks that record a run; none without a path."""
    if path is None:
        from hmrsim.timing.pacing import unwatched

        return nullcontext(unwatched)
    # Loads the MCAP writer, which takes 100 ms.
    from hmrsim.cli.record import recorded

    return recorded(path, settings)


def _serve(host: Host, periodic_tasks: Iterable[Callable[[], None]], on_ready: Callable[[], None]) -> None:
    """Run the simulation until its end or a signal."""
    from hmrsim.program.memory import collect_rarely

    signals: list[int] = []
    with on_signals(signals.append):
        collect_rarely()
        host.start()
        on_ready()
        while not signals and not host.wait(_WAIT_SECONDS):
            for task in periodic_tasks:
                task()
        host.stop()


def _show_ready(loaded: LoadedWorld, host: Host, url: str, *, as_json: bool) -> None:
    world, options = loaded.world, host.options
    ready: dict[str, Any] = {
        "ready": True,
        "endpoints": list(host.endpoints),
        "prefix": options.prefix,
        "world": {"name": world.name, "hash": loaded.hash},
        "robots": list(world.robots),
        **({"view": url} if url else {}),
    }
    words = ["ready", *(host.endpoints or options.connect), f"world={shlex.quote(printable(world.name))}"]
    words += [f"robots={len(world.robots)}", *((f"view={url}",) if url else ())]
    show_result(ready, " ".join(words), as_json=as_json)


def ros2_wires(settings: Ros2Settings) -> tuple[Wire, ...]:
    """Return the ROS 2 wires that the settings enable.

    Raises:
        BadOptions: The options don't fit together, or the environment's domain is invalid.
    """
    # Environment variables apply to all runs, so they are not an error in runs without ROS.
    if settings.ros_domain_id is not None and not settings.ros2 and not os.environ.get("HMRSIM_ROS_DOMAIN_ID"):
        raise BadOptions("--ros-domain-id is for --ros2; add that")
    if settings.ros_distro and not (settings.ros2 or settings.ros2dds or os.environ.get("HMRSIM_ROS_DISTRO")):
        raise BadOptions("--ros-distro is for --ros2 and --ros2dds; add one of them")
    if not (settings.ros2 or settings.ros2dds):
        return ()
    # Loads the codecs, which takes 40 ms.
    from hmrsim_zenoh.ros2 import wires

    distros = tuple(dict.fromkeys(settings.ros_distro))
    opened: list[Wire] = []
    if settings.ros2:
        domain = ros_domain_of_environment() if settings.ros_domain_id is None else settings.ros_domain_id
        opened.append(wires.RmwZenoh(domain, distros) if distros else wires.RmwZenoh(domain))
    if settings.ros2dds:
        opened.append(wires.Ros2Dds(distros[0]) if distros else wires.Ros2Dds())
    return tuple(opened)


class _Monitor:
    """Monitors properties during a run, and publishes each violation as an event of the world."""

    def __init__(self, path: Path, world: World) -> None:
        # Loads the properties, which takes 100 ms.
        from hmrsim.cli.worlds import show_findings
        from hmrsim.properties import Monitor, check_properties
        from hmrsim.properties.model.file import read_valid_properties

        self._simulator: Simulator | None = None
        self._running = True
        properties, flaws = read_valid_properties(path)
        show_findings(properties, [*flaws, *check_properties(properties, world)])
        self._monitor = Monitor(properties, world)

    @property
    def violated(self) -> bool:
        """True if a property was violated."""
        return bool(self._monitor.violations)

    def sink(self, simulator: Simulator) -> MonitorSink:
        """Return the monitor's sink; it comes after all others, which receive an event before its violations."""
        from hmrsim.properties import MonitorSink

        self._simulator = simulator
        return MonitorSink(simulator, self._monitor, self._publish)

    def end(self, at: float) -> None:
        """End the run; obligations that are still open remain undecided."""
        from hmrsim.engine.sim_time import stamp
        from hmrsim.properties import Ended

        self._running = False
        self._monitor.end(stamp(at), Ended("stopped"))

    def _publish(self, violation: Violation) -> None:
        from hmrsim.engine.sim_time import stamp
        from hmrsim.events.simulation import PropertyViolated
        from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
        from hmrsim.protocol.outputs import EventStamped

        simulator = self._simulator
        at = violation.at / NANOSECONDS
        event = PropertyViolated(violation.property, violation.subject, at, violation.reason, violation.text)
        if simulator is not None and self._running:
            simulator.publisher.emit(EventStamped(stamp(simulator.now), event))
        else:
            _log.error("sim %.3f | %s", at, event.describe())
