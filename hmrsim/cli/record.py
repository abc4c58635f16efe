"""``hmrsim record``: record a simulator's publications to a file, over the network."""

from __future__ import annotations

import math
import queue
import time
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Final

from hmrsim.cli import numbers
from hmrsim.cli.connection import add_connection_options, connected
from hmrsim.cli.exits import ExitCode
from hmrsim.cli.output import show_json, warn
from hmrsim.cli.rosout import told
from hmrsim.cli.run_recording import account
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.program.signals import on_signals
from hmrsim_zenoh.errors import Unreachable
from hmrsim_zenoh.recording.listening import Listener
from hmrsim_zenoh.recording.recorder import Recorder
from hmrsim_zenoh.recording.writing import RecordingFile
from hmrsim_zenoh.wire.options import ENVIRONMENT

if TYPE_CHECKING:
    import argparse

    from hmrsim_zenoh.client.client import Client

_EXAMPLES: Final = f"""\
examples:
  hmrsim record run.mcap
  hmrsim record run.mcap --duration 60 --connect tcp/10.0.0.7:7447
  hmrsim record run.mcap && hmrsim view run.mcap

{ENVIRONMENT}"""

_LOOK: Final = 0.2
_GRACE: Final = 5.0
"""Wall seconds within which a simulator may come back, as when it is restarted."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim record``."""
    parser.description = (
        "Record everything that a simulator publishes to an MCAP file until Ctrl-C, or until the simulator is gone."
    )
    parser.epilog = _EXAMPLES
    parser.add_argument("file", type=Path, metavar="OUT.mcap", help="an existing file is overwritten")
    parser.add_argument(
        "--duration",
        type=numbers.positive,
        default=math.inf,
        metavar="S",
        help="end after this many simulated seconds (default: never)",
    )
    parser.add_argument("--json", action="store_true", help="print how much was recorded as one JSON object")
    add_connection_options(parser)
    parser.set_defaults(function=_record)


def _record(args: argparse.Namespace) -> int:
    signals: list[int] = []
    with on_signals(signals.append), connected(args) as (client, _), RecordingFile(args.file) as file:
        recorder = Recorder(file, told)
        with Listener(client, recorder) as listener:
            _follow(client, listener, recorder, signals, args)
    if listener.lost:
        warn(f"{listener.lost} messages came faster than they could be written, and are not in it")
    if args.json:
        begin, end = recorder.time.begin, recorder.time.now
        written = {"messages": file.messages, "bytes": args.file.stat().st_size, "lost": listener.lost}
        show_json({"file": str(args.file), **written, "begin": begin / NANOSECONDS, "end": end / NANOSECONDS})
    else:
        warn(account(args.file, file, recorder))
    return ExitCode.DONE


def _follow(
    client: Client, listener: Listener, recorder: Recorder, signals: list[int], args: argparse.Namespace
) -> None:
    """Record until a signal, the end of the time, or of the simulator.

    Raises:
        Unreachable: The simulator does not describe itself.
    """
    began = looked = seen = time.monotonic()
    said = False
    while not signals:
        with suppress(queue.Empty):
            listener.work(_LOOK)
        if listener.begun and not said:
            said = True
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
