"""``hmrsim view``: show a simulation, live or recorded, in a browser."""

from __future__ import annotations

import queue
import webbrowser
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Final

from hmrsim.cli.exits import ExitCode
from hmrsim.cli.output import show, show_json
from hmrsim.program.log_options import add_log_options, logging_to_stderr
from hmrsim.program.signals import on_signals
from hmrsim.settings.arguments import reader_of
from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.recording import open_recording
from hmrsim_zenoh.settings import ViewSettings
from hmrsim_zenoh.view import DEFAULT_HOST, DEFAULT_PORT
from hmrsim_zenoh.view.live import Live
from hmrsim_zenoh.view.recorded import Recorded
from hmrsim_zenoh.view.server import ViewServer
from hmrsim_zenoh.wire.options import ENVIRONMENT, add_session_options, session_options

if TYPE_CHECKING:
    import argparse

    from hmrsim_zenoh.view.server import Source

_EXAMPLES: Final = f"""\
examples:
  hmrsim view --open
  hmrsim view --connect tcp/10.0.0.7:7447 --port 8080
  hmrsim view --host 0.0.0.0
  hmrsim view shift.mcap

{ENVIRONMENT}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim view``."""
    parser.description = (
        "Serve a page that shows a simulator live, or plays a recording, until Ctrl-C. Prints `ready URL`.\n"
        "The simulator may be on another machine; when it is restarted, the page continues with it."
    )
    parser.epilog = _EXAMPLES
    parser.add_argument(
        "recording",
        nargs="?",
        type=Path,
        metavar="RECORDING.mcap",
        help="play this recording instead of showing a simulator",
    )
    group = parser.add_argument_group("page")
    group.add_argument(
        "--host",
        default=DEFAULT_HOST,
        metavar="ADDRESS",
        help="address to serve on; if not local, the URL has a token that every page needs (default: %(default)s)",
    )
    group.add_argument(
        "--port",
        type=reader_of(ViewSettings, "view"),
        default=DEFAULT_PORT,
        metavar="PORT",
        help="… 0 for a free one (default: %(default)s)",
    )
    group.add_argument("--open", action="store_true", help="open the page in the browser")
    add_session_options(parser)
    add_log_options(parser)
    parser.add_argument("--json", action="store_true", help="print that it is ready as one JSON object")
    parser.set_defaults(function=_view)


def _view(args: argparse.Namespace) -> int:
    # This may take long; meanwhile a signal ends the process at once.
    recording = None if args.recording is None else _recording(args.recording)
    signals: queue.SimpleQueue[int] = queue.SimpleQueue()
    with on_signals(signals.put), logging_to_stderr(args), ExitStack() as stack:
        source = recording or _simulator(args, stack)

        if signals.empty():
            server = stack.enter_context(ViewServer(source, host=args.host, port=args.port))
            if args.json:
                show_json({"ready": True, "url": server.url})
            else:
                show(f"ready {server.url}")
            if args.open:
                webbrowser.open(server.url)
        signals.get()
    return ExitCode.DONE


def _simulator(args: argparse.Namespace, stack: ExitStack) -> Source:
    """Return the simulator.

    Raises:
        NobodyThere: No simulator answers.
    """
    options = session_options(args)
    client = stack.enter_context(Client(options, clock="realtime"))
    client.wait_for_simulator(options.timeout)
    return Live(client.session, client.keys)


def _recording(path: Path) -> Source:
    """Return a recording.

    Raises:
        RecordingError: It is not a recording.
    """
    return Recorded(open_recording(path))
