"""What ``hmrsim record`` does: it writes what it hears until a signal, or until the simulator has gone."""

from __future__ import annotations

import argparse
import queue
import time
from contextlib import suppress
from typing import TYPE_CHECKING, Final

from hmrsim.cli.connection import connected
from hmrsim.cli.exits import ExitCode
from hmrsim.cli.output import show_json, warn
from hmrsim.cli.rosout import told
from hmrsim.cli.run_recording import account
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.program.outputs import check_outputs
from hmrsim.program.signals import on_signals
from hmrsim_zenoh.errors import Unreachable
from hmrsim_zenoh.recording.listener import Listener
from hmrsim_zenoh.recording.recorder import Recorder
from hmrsim_zenoh.recording.writer import RecordingFile
from hmrsim_zenoh.wire.options import session_options

if TYPE_CHECKING:
    from hmrsim_zenoh.client.client import Client

_LOOK: Final = 0.2
_GRACE: Final = 5.0
"""Wall seconds within which a simulator may come back, as when it is restarted."""


def record(args: argparse.Namespace) -> int:
    """Record what a simulator publishes; return the exit code."""
    check_outputs([("OUT.mcap", args.file)], [session_options(args).zenoh_config])
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
