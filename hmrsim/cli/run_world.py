"""What ``hmrsim run`` does: it serves a world until a signal, or the end of its time."""

from __future__ import annotations

import argparse
import math
import secrets
import shlex
import sys
import traceback
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from typing import TYPE_CHECKING, Any, Final

from hmrsim import plugins
from hmrsim.cli.exits import ExitCode
from hmrsim.cli.heap import Heap
from hmrsim.cli.output import show, show_json, warn
from hmrsim.cli.ros2_options import ros2_wires
from hmrsim.cli.run_display import display
from hmrsim.cli.tracing import TraceFile
from hmrsim.cli.view_options import check_page, check_port, viewed
from hmrsim.cli.worlds import FirstFindings, read_world, show_warnings
from hmrsim.errors import HmrsimError, printable
from hmrsim.program.garbage import collect_rarely
from hmrsim.program.log_options import ServerLogOptions
from hmrsim.program.outputs import check_outputs
from hmrsim.program.signals import on_signals
from hmrsim.protocol.time import REALTIME
from hmrsim.settings.arguments import read_settings
from hmrsim.settings.file import read_file
from hmrsim.settings.run import TIME_STANDS, RunSettings, TraceSettings
from hmrsim.world_checks.obstructions import check_obstructions
from hmrsim_zenoh.errors import ParticipantLost
from hmrsim_zenoh.hosting.host import Host
from hmrsim_zenoh.hosting.served_simulation import unwatched
from hmrsim_zenoh.settings import SERVED, MonitorSettings, RecordSettings, Ros2Settings, ViewSettings
from hmrsim_zenoh.wire.exposure import exposed
from hmrsim_zenoh.wire.options import SessionOptions

if TYPE_CHECKING:
    from pathlib import Path

    from hmrsim.cli.run_monitor import RunMonitor
    from hmrsim.cli.view_options import View
    from hmrsim.world import World
    from hmrsim.world_checks import LoadedWorld
    from hmrsim_zenoh.hosting.served_simulation import Watchers

_MAX_WARNINGS: Final = 5
"""Warnings of traffic that are printed; a fleet with more of them has them in common."""

_LOOK: Final = 0.1
"""Wall seconds of one wait: Python handles a signal only between waits."""


class _Asked:
    """The settings of a run: from options and variables, else from the settings file, else the defaults."""

    def __init__(self, args: argparse.Namespace) -> None:
        self.below = read_file(args.settings, SERVED) if args.settings else {}
        read = partial(read_settings, args, below=self.below)
        self.run = read(RunSettings).model_copy(update={"run_id": secrets.token_hex(8)})
        self.session = read(SessionOptions)
        self.ros2 = read(Ros2Settings)
        self.trace = read(TraceSettings).trace
        self.record = read(RecordSettings).record
        self.monitor = read(MonitorSettings).monitor
        self.view = read(ViewSettings).view
        self.log_level = read(ServerLogOptions).number


def run(args: argparse.Namespace) -> int:
    """Serve the world that the options name; return the exit code."""
    asked = _Asked(args)
    run, wires = asked.run, ros2_wires(asked.ros2)
    check_port(asked.view)
    check_page(asked.view, asked.session)
    obstructions = FirstFindings(check_obstructions, _MAX_WARNINGS)
    loaded = read_world(args, below=asked.below, further=[obstructions])
    check_outputs(
        [("--trace", asked.trace), ("--record", asked.record)],
        [*loaded.files, args.settings, asked.monitor, asked.session.zenoh_config],
    )
    show_warnings(loaded)
    if obstructions.left_out:
        warn(f"and {obstructions.left_out} more warnings of traffic; `hmrsim map validate --traffic WORLD` lists all")
    monitor = _monitor(asked.monitor, loaded.world)
    if run.clock == REALTIME and run.real_time_factor == 0 and run.duration < math.inf:
        warn(f"--duration {run.duration:g}: as fast as possible, {TIME_STANDS}")
    trace = TraceFile(asked.trace, loaded.world, run)
    screen = display(loaded.world.name, asked.log_level, on_terminal=sys.stderr.isatty())
    heap = Heap()
    with _recording(asked.record, run) as recording:
        host = Host(
            loaded,
            asked.session,
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
        for endpoint in exposed(asked.session, host.endpoints):
            warn(f"{endpoint} is open: all who reach it can drive the robots; encrypt it with --secure DIR")
        with host, trace.opened(host.simulator), screen.shown(host) as refresh:
            if run.strict:
                plugins.check()
            with viewed(asked.view, host.endpoints or asked.session.connect, asked.session) as view:
                _serve(
                    host,
                    [refresh, heap.give_back],
                    lambda: _tell_ready(loaded, host, asked.session, view, as_json=args.json),
                )
            if monitor is not None:
                monitor.end(host.simulator.now)
            if isinstance(host.error, HmrsimError) and not isinstance(host.error, ParticipantLost):
                raise host.error
    if isinstance(host.error, HmrsimError):
        # The run is complete.
        raise host.error
    if host.error is not None:
        traceback.print_exception(host.error)
        return ExitCode.FAILED
    return ExitCode.FAILED if monitor is not None and monitor.violated else ExitCode.DONE


def _monitor(path: Path | None, world: World) -> RunMonitor | None:
    """Return what watches over the properties of a file, if one is given."""
    if path is None:
        return None
    # Loads all of the properties, which takes 100 ms and is needed for monitored runs only.
    from hmrsim.cli.run_monitor import RunMonitor  # noqa: PLC0415

    return RunMonitor(path, world)


def _recording(path: Path | None, settings: RunSettings) -> AbstractContextManager[Watchers]:
    """Return the context of the sink that records a run, if a path is given."""
    if path is None:
        return nullcontext(unwatched)
    # Loads the MCAP writer, which takes 100 ms and is needed for recorded runs only.
    from hmrsim.cli.run_recording import recorded  # noqa: PLC0415

    return recorded(path, settings)


def _serve(host: Host, now_and_then: Sequence[Callable[[], None]], tell_ready: Callable[[], None]) -> None:
    """Run the simulation until its end or a signal."""
    signals: list[int] = []
    with on_signals(signals.append):
        collect_rarely()
        host.start()
        tell_ready()
        while not signals and not host.wait(_LOOK):
            for each in now_and_then:
                each()
        host.stop()


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
