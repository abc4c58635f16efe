"""``hmrsim view``: show a simulation in a browser, live or recorded; also the page of ``hmrsim run --view``."""

from __future__ import annotations

import argparse
import errno
import json
import logging
import queue
import socket
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from hmrsim.cli.connection import VIEWER
from hmrsim.cli.options import ExitCode, add_json, whole_in
from hmrsim.cli.output import show_result
from hmrsim.errors import reason_of
from hmrsim.program.log_options import add_log_options, logging_to_stderr
from hmrsim.program.signals import on_signals
from hmrsim_zenoh.errors import BadOptions
from hmrsim_zenoh.view import DEFAULT_HOST, DEFAULT_PORT
from hmrsim_zenoh.wire.options import add_session_options, session_options

if TYPE_CHECKING:
    from hmrsim.cli.child import Child
    from hmrsim_zenoh.view.server import Source
    from hmrsim_zenoh.wire.enclave import Enclave
    from hmrsim_zenoh.wire.options import SessionOptions

_START_SECONDS: Final = 30.0
_EXIT_TIMEOUT: Final = 1.0

_log = logging.getLogger(__name__)


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim view``."""
    parser.description = (
        "Serve a page that shows a simulator live, or plays a recording, until Ctrl-C. Prints `ready URL`.\n"
        "The simulator may be on another machine; when it is restarted, the page continues with it."
    )
    parser.epilog = """\
examples:
  hmrsim view --open
  hmrsim view --connect tcp/10.0.0.7:7447 --port 8080
  hmrsim view --host 0.0.0.0
  hmrsim view shift.mcap"""
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
        type=whole_in(0, 65_535, "a port; expected a whole number from 0 to 65535"),
        default=DEFAULT_PORT,
        metavar="PORT",
        help="… 0 for a free one (default: %(default)s)",
    )
    group.add_argument("--open", action="store_true", help="open the page in the browser")
    add_session_options(parser)
    add_log_options(parser)
    add_json(parser, "print the ready message as one JSON object")
    parser.set_defaults(function=_view)


def _view(args: argparse.Namespace) -> int:
    import webbrowser

    from hmrsim_zenoh.view.server import ViewServer

    # Opening a recording may take long; until then, a signal ends the process at once.
    recording = None if args.recording is None else _recorded(args.recording)
    options = session_options(args, VIEWER)
    enclave = _server_enclave(options)
    signals: queue.SimpleQueue[int] = queue.SimpleQueue()
    with on_signals(signals.put), logging_to_stderr(args), ExitStack() as stack:
        source = recording or _simulator(options, enclave, stack)
        if signals.empty():
            server = stack.enter_context(ViewServer(source, host=args.host, port=args.port, enclave=enclave))
            show_result({"ready": True, "url": server.url}, f"ready {server.url}", as_json=args.json)
            if args.open:
                webbrowser.open(server.url)
        signals.get()
    return ExitCode.DONE


def _recorded(path: Path) -> Source:
    from hmrsim_zenoh.recording import Recording
    from hmrsim_zenoh.view.sources import Recorded

    return Recorded(Recording(path))


def _server_enclave(options: SessionOptions) -> Enclave | None:
    """Return the enclave whose certificate the page is served with; None for HTTP."""
    from hmrsim_zenoh.wire.session import enclave_of

    enclave = enclave_of(options)
    if enclave and enclave.member.role == "controller":
        raise BadOptions(f"--secure: the certificate of {enclave.name!r} is for clients; serve the page as a viewer")
    return enclave


def _simulator(options: SessionOptions, enclave: Enclave | None, stack: ExitStack) -> Source:
    """Connect to the running simulator and return it as a source."""
    from hmrsim_zenoh.client.client import Client
    from hmrsim_zenoh.view.access import VisitorRights
    from hmrsim_zenoh.view.sources import Live

    client = stack.enter_context(Client(options, clock="realtime"))
    client.wait_for_simulator(options.timeout)
    return Live(client.session, client.keys, VisitorRights(enclave, client.keys.prefix) if enclave else None)


def check_page(view: int | None, options: SessionOptions) -> None:
    """Check that a page can be served on port *view* with a simulator's session options, unless the port is None.

    Call it before anything is started or overwritten.

    Raises:
        BadOptions: The port is not available, or the page has no enclave.
    """
    from hmrsim_zenoh.wire.enclave import SIMULATOR, find_enclave

    if view is None:
        return
    try:
        socket.create_server((DEFAULT_HOST, view)).close()
    except OSError as error:
        why = "is taken" if error.errno == errno.EADDRINUSE else f"is not available ({reason_of(error)})"
        raise BadOptions(f"--view: {DEFAULT_HOST}:{view} {why}; name another with --view, 0 for a free one") from None
    if options.secure and find_enclave(options.secure, "viewer").member.role == SIMULATOR:
        raise BadOptions(
            f"--view: {str(options.secure)!r} is the simulator's enclave; the page needs a viewer's: name the keystore "
            "with --secure, or run `hmrsim view --secure` with another enclave"
        )


def _url(server: Child, lines: queue.SimpleQueue[str | None]) -> str:
    """Wait until the page of a server can be opened, and return its URL."""
    try:
        line = lines.get(timeout=_START_SECONDS)
    except queue.Empty:
        line = None
    if line is None:
        server.code(_EXIT_TIMEOUT)
        # The option of the run has another name than the option of `hmrsim view`.
        why = server.errors.rpartition("\n")[2].replace("--port", "--view")
        raise BadOptions(f"--view: {why or 'the server of the page does not start'}")
    ready: dict[str, Any] = json.loads(line)
    _log.info("the live picture is at %s", ready["url"])
    return str(ready["url"])


@contextmanager
def viewed(view: int | None, endpoints: Sequence[str], options: SessionOptions) -> Iterator[Callable[[], str]]:
    """Serve the page of a simulator in another process within the context.

    Args:
        view: The port; None for no page.
        endpoints: The endpoints of the simulator.
        options: The options of the simulator's session.

    Yields:
        A function that waits until the page can be opened and returns its URL, or raises `BadOptions`; without a page
        it returns an empty text.
    """
    from hmrsim.cli.child import Child
    from hmrsim_zenoh.wire.options import from_here

    if view is None:
        yield lambda: ""
        return
    words = [word for endpoint in endpoints for word in ("--connect", from_here(endpoint))]
    if options.secure:
        words += ["--secure", str(options.secure)]
    if options.zenoh_config:
        # The configuration may have certificates. A client does not listen.
        words += ["--zenoh-config", str(options.zenoh_config), "--mode", "client"]
    words += ["--prefix", options.prefix, "--port", str(view), "--timeout", str(_START_SECONDS)]
    lines: queue.SimpleQueue[str | None] = queue.SimpleQueue()
    with Child("view", "hmrsim.cli:main", ["view", *words, "--json"], lines.put) as server:
        yield lambda: _url(server, lines)
