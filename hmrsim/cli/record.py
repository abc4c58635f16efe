"""``hmrsim record``: record a running simulator to an MCAP file, and the sink behind ``hmrsim run --record``."""

from __future__ import annotations

import argparse
import math
import queue
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Final

from hmrsim.cli.connection import connected
from hmrsim.cli.event_log import text_of
from hmrsim.cli.options import ExitCode, add_connection_options, add_json, positive
from hmrsim.cli.output import show_json, warn
from hmrsim.errors import printable
from hmrsim.events import Severity
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.interfaces.rcl_interfaces import Log
from hmrsim.program.files import check_outputs
from hmrsim.program.signals import on_signals
from hmrsim.protocol.time import LOCKSTEP
from hmrsim_zenoh.errors import Unreachable
from hmrsim_zenoh.recording.recorder import LogLine, Recorder
from hmrsim_zenoh.recording.sink import RecordingSink
from hmrsim_zenoh.recording.writer import RecordingFile
from hmrsim_zenoh.wire.options import session_options

if TYPE_CHECKING:
    from hmrsim.events import Event
    from hmrsim.protocol.sinks import Sink
    from hmrsim.settings.run import RunSettings
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.timing.pacing import Pacing, Watchers
    from hmrsim_zenoh.client.client import Client
    from hmrsim_zenoh.recording.listener import Listener


_LOOK: Final = 0.2
"""Wall seconds between checks of the simulator."""
_GRACE: Final = 5.0
"""Wall seconds for which the simulator may be gone, for instance to restart, or may take to describe its world."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim record``."""
    parser.description = (
        "Record everything that a simulator publishes to an MCAP file until Ctrl-C, or until the simulator is gone."
    )
    parser.epilog = """\
examples:
  hmrsim record run.mcap
  hmrsim record run.mcap --duration 60 --connect tcp/10.0.0.7:7447
  hmrsim record run.mcap && hmrsim view run.mcap"""
    parser.add_argument("file", type=Path, metavar="OUT.mcap", help="an existing file is overwritten")
    parser.add_argument(
        "--duration",
        type=positive,
        default=math.inf,
        metavar="S",
        help="end after this many simulated seconds (default: never)",
    )
    add_json(parser, "print a summary of the recording as one JSON object")
    add_connection_options(parser)
    parser.set_defaults(function=_record)


def _record(args: argparse.Namespace) -> int:
    from hmrsim_zenoh.recording.listener import Listener

    check_outputs([("OUT.mcap", args.file)], [session_options(args).zenoh_config])
    signals: list[int] = []
    with on_signals(signals.append), connected(args) as (client, _), RecordingFile(args.file) as file:
        recorder = Recorder(file, rosout)
        with Listener(client, recorder) as listener:
            _follow(client, listener, recorder, signals, args)
    if listener.lost:
        warn(f"{listener.lost} messages arrived faster than they could be written, and are missing from the file")
    if args.json:
        begin, end = recorder.time.begin, recorder.time.now
        written = {"messages": file.messages, "bytes": args.file.stat().st_size, "lost": listener.lost}
        show_json({"file": str(args.file), **written, "begin": begin / NANOSECONDS, "end": end / NANOSECONDS})
    else:
        warn(summary(args.file, file, recorder))
    return ExitCode.DONE


def _follow(
    client: Client, listener: Listener, recorder: Recorder, signals: list[int], args: argparse.Namespace
) -> None:
    """Record until a signal arrives, the duration is over, or the simulator is gone."""
    began = looked = seen = time.monotonic()
    announced = False
    while not signals:
        with suppress(queue.Empty):
            listener.work(_LOOK)
        if listener.begun and not announced:
            announced = True
            warn(f"recording to {args.file}")
        if recorder.time.now - recorder.time.begin >= args.duration * NANOSECONDS:
            recorder.settle()
            return
        now = time.monotonic()
        if now - looked < _LOOK:
            continue
        looked = now
        if not listener.begun and now - began > _GRACE:
            raise Unreachable("the simulator answers, but does not describe its world")
        if not client.alive:
            if now - seen > _GRACE:
                warn("the simulator is gone")
                break
            continue
        seen = now
        if listener.interrupted:
            listener.query_again()
    listener.drain()


_WORLD: Final = "world"
"""The logger's name in messages about the world as a whole."""

_LEVELS: Final[Mapping[Severity, int]] = {
    Severity.INFO: Log.INFO,
    Severity.WARNING: Log.WARN,
    Severity.ERROR: Log.ERROR,
}


def rosout(event: Event) -> LogLine | None:
    """Return the log line of an event for the topic ``/rosout``; None for events that are too frequent for a log."""
    text = text_of(event)
    return LogLine(_LEVELS[event.severity], event.subject or _WORLD, printable(text)) if text else None


@contextmanager
def recorded(path: Path, settings: RunSettings) -> Iterator[Watchers]:
    """Yield a factory of the sink that records a run to a file; the file is complete when the context ends."""
    recordings: list[tuple[RecordingFile, Recorder, RecordingSink]] = []
    with ExitStack() as files:

        def watchers(simulator: Simulator, pacing: Pacing) -> Sequence[Sink]:
            file = files.enter_context(RecordingFile(path, reproducible=settings.clock == LOCKSTEP))
            recorder = Recorder(file, rosout)
            sink = RecordingSink(simulator, recorder, lambda: pacing.state, clock_rate=settings.clock_rate)
            recordings.append((file, recorder, sink))
            warn(f"recording to {path}")
            return (sink,)

        yield watchers
        for _file, _recorder, sink in recordings:
            sink.close()
    for file, recorder, _sink in recordings:
        warn(summary(path, file, recorder))


def summary(path: Path, file: RecordingFile, recorder: Recorder) -> str:
    """Return a line with the duration, the number of messages and the size of a recording."""
    seconds = (recorder.time.now - recorder.time.begin) / NANOSECONDS
    text = f"recorded {seconds:.1f} s: {file.messages} messages"
    try:
        size = path.stat().st_size
    except OSError:
        return f"{text}, but {path} is no longer there: it was deleted or moved meanwhile"
    return f"{text}, {size / 1e6:.1f} MB in {path}"
