"""``hmrsim run --view``: the page of a run, served by a separate process, at no cost to the simulation."""

from __future__ import annotations

import errno
import json
import logging
import queue
import socket
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final

from hmrsim.cli.child import Child
from hmrsim.errors import reason_of
from hmrsim_zenoh.errors import BadOptions
from hmrsim_zenoh.view import DEFAULT_HOST
from hmrsim_zenoh.wire.enclave import SIMULATOR, find_enclave
from hmrsim_zenoh.wire.endpoints import from_here

if TYPE_CHECKING:
    from hmrsim_zenoh.wire.options import SessionOptions

_START_SECONDS: Final = 30.0
_EXIT_TIMEOUT: Final = 1.0

_log = logging.getLogger(__name__)


def check_page(view: int | None, options: SessionOptions) -> None:
    """Check that a page can be served with the options of a simulator's session, if one is wanted.

    Raises:
        BadOptions: There is no enclave for it.
    """
    if view is not None and options.secure and find_enclave(options.secure, "viewer").member.role == SIMULATOR:
        raise BadOptions(
            f"--view: {str(options.secure)!r} is the simulator's enclave; the page needs a viewer's: name the keystore "
            "with --secure, or run `hmrsim view --secure` with another enclave"
        )


def check_port(view: int | None) -> None:
    """Check that a page can be served on a port, if one is wanted, before anything is started or overwritten.

    Raises:
        BadOptions: Another process listens there.
    """
    try:
        if view is not None:
            socket.create_server((DEFAULT_HOST, view)).close()
    except OSError as error:
        why = "is taken" if error.errno == errno.EADDRINUSE else f"is not available ({reason_of(error)})"
        raise BadOptions(f"--view: {DEFAULT_HOST}:{view} {why}; name another with --view, 0 for a free one") from None


class View:
    """The process that serves the page of a run."""

    def __init__(self, arguments: Sequence[str]) -> None:
        self._lines: queue.SimpleQueue[str | None] = queue.SimpleQueue()
        self._child = Child("view", "hmrsim.cli:main", ["view", *arguments, "--json"], self._lines.put)

    def url(self) -> str:
        """Return the URL of the page, once it can be opened.

        Raises:
            BadOptions: It can't be served; the text says why.
        """
        try:
            line = self._lines.get(timeout=_START_SECONDS)
        except queue.Empty:
            line = None
        if line is None:
            self._child.code(_EXIT_TIMEOUT)
            # Its options differ from those of the run.
            why = self._child.errors.rpartition("\n")[2].replace("--port", "--view")
            raise BadOptions(f"--view: {why or 'the server of the page does not start'}")
        ready: dict[str, Any] = json.loads(line)
        _log.info("the live picture is at %s", ready["url"])
        return str(ready["url"])

    def stop(self) -> None:
        """End it."""
        self._child.stop()


@contextmanager
def viewed(view: int | None, endpoints: Sequence[str], options: SessionOptions) -> Iterator[View | None]:
    """Serve the page on port *view*, if it is one, of the simulator that is reached there; end it with the context.

    *options* are those of the simulator's session.
    """
    if view is None:
        yield None
        return
    words = [word for endpoint in endpoints for word in ("--connect", from_here(endpoint))]
    if options.secure:
        words += ["--secure", str(options.secure)]
    if options.zenoh_config:
        # Its certificates; a client does not listen.
        words += ["--zenoh-config", str(options.zenoh_config), "--mode", "client"]
    server = View([*words, "--prefix", options.prefix, "--port", str(view), "--timeout", str(_START_SECONDS)])
    try:
        yield server
    finally:
        server.stop()
