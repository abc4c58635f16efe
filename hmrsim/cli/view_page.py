"""What ``hmrsim view`` does: it serves the page until a signal."""

from __future__ import annotations

import argparse
import queue
import webbrowser
from contextlib import ExitStack
from typing import TYPE_CHECKING

from hmrsim.cli.connection import VIEWER
from hmrsim.cli.exits import ExitCode
from hmrsim.cli.output import show, show_json
from hmrsim.program.log_options import logging_to_stderr
from hmrsim.program.signals import on_signals
from hmrsim.settings.arguments import reader_of
from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.errors import BadOptions
from hmrsim_zenoh.settings import ViewSettings
from hmrsim_zenoh.view.live import Live
from hmrsim_zenoh.view.server import ViewServer
from hmrsim_zenoh.view.visitors import Rights
from hmrsim_zenoh.wire.options import session_options
from hmrsim_zenoh.wire.session import enclave_of

if TYPE_CHECKING:
    from pathlib import Path

    from hmrsim_zenoh.view.recorded import Recorded
    from hmrsim_zenoh.view.server import Source
    from hmrsim_zenoh.wire.enclave import Enclave
    from hmrsim_zenoh.wire.options import SessionOptions

port = reader_of(ViewSettings, "view")
"""Reads the value of ``--port``."""


def serve(args: argparse.Namespace) -> int:
    """Serve the page of a simulator or of a recording; return the exit code."""
    # This may take long; meanwhile a signal ends the process at once.
    recording = None if args.recording is None else _recorded(args.recording)
    options = session_options(args, VIEWER)
    enclave = server_of(options)
    signals: queue.SimpleQueue[int] = queue.SimpleQueue()
    with on_signals(signals.put), logging_to_stderr(args), ExitStack() as stack:
        source = recording or _simulator(options, enclave, stack)

        if signals.empty():
            server = stack.enter_context(ViewServer(source, host=args.host, port=args.port, enclave=enclave))
            if args.json:
                show_json({"ready": True, "url": server.url})
            else:
                show(f"ready {server.url}")
            if args.open:
                webbrowser.open(server.url)
        signals.get()
    return ExitCode.DONE


def _recorded(path: Path) -> Recorded:
    # Loads what reads recordings, which a live picture does not need.
    from hmrsim_zenoh.recording import open_recording
    from hmrsim_zenoh.view.recorded import Recorded

    return Recorded(open_recording(path))


def server_of(options: SessionOptions) -> Enclave | None:
    """Return the enclave whose certificate the page is served with; None for HTTP.

    Raises:
        BadOptions: It is for clients only.
    """
    enclave = enclave_of(options)
    if enclave and enclave.member.role == "controller":
        raise BadOptions(f"--secure: the certificate of {enclave.name!r} is for clients; serve the page as a viewer")
    return enclave


def _simulator(options: SessionOptions, enclave: Enclave | None, stack: ExitStack) -> Source:
    """Return the simulator.

    Raises:
        SimulatorNotFound: No simulator answers.
    """
    client = stack.enter_context(Client(options, clock="realtime"))
    client.wait_for_simulator(options.timeout)
    return Live(client.session, client.keys, Rights(enclave, client.keys.prefix) if enclave else None)
