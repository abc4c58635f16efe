"""The HTTP server of the page: its files, the palette and the routes of its source."""

from __future__ import annotations

import asyncio
import errno
import logging
import socket
import ssl
import threading
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Protocol, Self

import uvicorn
from starlette.applications import Starlette
from starlette.responses import FileResponse
from starlette.routing import BaseRoute, Mount, Route
from starlette.staticfiles import StaticFiles
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.exceptions import InvalidState

from hmrsim.errors import HmrsimError, reason_of
from hmrsim_zenoh.errors import BadOptions, PortTaken
from hmrsim_zenoh.view import DEFAULT_HOST, DEFAULT_PORT
from hmrsim_zenoh.view.access import Gate, NamedProtocol
from hmrsim_zenoh.view.sources import MAX_PAGES
from hmrsim_zenoh.wire.enclave import AUTHORITY, CERTIFICATE, KEY
from hmrsim_zenoh.wire.options import is_loopback

if TYPE_CHECKING:
    from contextlib import AbstractAsyncContextManager

    from starlette.requests import Request

    from hmrsim_zenoh.wire.enclave import Enclave

_PAGE: Final = Path(__file__).parent / "page"
_MAX_REQUEST: Final = 2**20
"""The largest request of a page in bytes."""
_GRACE: Final = 1
"""Wall seconds for responses in progress to end."""
_PATIENCE: Final = 5.0
_ANY_ADDRESS: Final = {"0.0.0.0", "::"}  # noqa: S104 - compared with, not bound to
_ELSEWHERE: Final = "192.0.2.1", 9
"""An address that is never assigned (RFC 5737)."""

_log = logging.getLogger(__name__)


class Source(Protocol):
    """The source of a page: a simulator or a recording."""

    def routes(self) -> list[BaseRoute]:
        """Return the routes of the source beside the page's files."""

    def opened(self) -> AbstractAsyncContextManager[None]:
        """Return a context manager that the event loop enters before the first page and exits after the last."""


class ViewServer:
    """Serves the page in its own thread until it is closed.

    Args:
        host: Address to bind to; a token is required unless it is the loopback.
        port: Port to bind to; 0 for a free one.
        enclave: The certificate by which it serves HTTPS; None for HTTP. Visitors may show one of the same authority.

    Attributes:
        url: The URL of the page, with the token if there is one.

    Raises:
        PortTaken: Another process listens there.
        BadOptions: The host is not an address of this machine.
    """

    def __init__(
        self, source: Source, *, host: str = DEFAULT_HOST, port: int = DEFAULT_PORT, enclave: Enclave | None = None
    ) -> None:
        self._socket = _bound(host, port)
        gate = Gate(_application(source), host, enclave.access_control.rules if enclave else None)
        self.url = _url(host, self._socket.getsockname()[1], gate.token, secured=enclave is not None)
        self._server = _Server(
            uvicorn.Config(
                gate,
                loop="asyncio",
                http=NamedProtocol,
                ws=_WebSockets,
                lifespan="on",
                log_config=None,
                log_level="info",
                access_log=False,
                server_header=False,
                date_header=False,
                proxy_headers=False,
                ws_max_size=_MAX_REQUEST,
                # With room for the files of a page beside those that are open; beyond it the answer is 503.
                limit_concurrency=4 * MAX_PAGES,
                # On the loopback, compression costs more than it saves.
                ws_per_message_deflate=not is_loopback(host),
                timeout_graceful_shutdown=_GRACE,
                **_tls(enclave),
            )
        )
        self._log = _Forwarded()
        self._failure: HmrsimError | None = None
        self._thread = threading.Thread(target=self._run, name="hmrsim view", daemon=True)
        self._thread.start()
        self._server.begun.wait()
        if self._failure is not None:
            self._socket.close()
            self._log.close()
            raise self._failure

    def __enter__(self) -> Self:
        """Return the server."""
        return self

    def __exit__(self, *_error: object) -> None:
        """Close the server."""
        self.close()

    def close(self) -> None:
        """Disconnect all pages, and return when the server has ended."""
        self._server.end()
        self._thread.join(_PATIENCE)
        self._log.close()

    def _run(self) -> None:
        try:
            # Uvicorn raises SystemExit when it can't start, after it has logged the reason.
            with suppress(SystemExit):
                asyncio.run(self._server.serve(sockets=[self._socket]))
        finally:
            if not self._server.begun.is_set():
                self._failure = HmrsimError("the page's server did not start; --log-level debug shows the reason")
                self._server.begun.set()


class _Server(uvicorn.Server):
    """Uvicorn's server, which waits for its end instead of polling ten times a second."""

    def __init__(self, config: uvicorn.Config) -> None:
        super().__init__(config)
        self.begun = threading.Event()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._ended = asyncio.Event()

    async def main_loop(self) -> None:
        await self.on_tick(0)
        self._loop = asyncio.get_running_loop()
        self.begun.set()
        await self._ended.wait()

    def end(self) -> None:
        """End the server, from another thread; repeated calls do nothing."""
        if self._loop is not None:
            with suppress(RuntimeError):
                self._loop.call_soon_threadsafe(self._ended.set)


class _WebSockets(WebSocketsSansIOProtocol):
    """Uvicorn's WebSockets, which can also be shut down while a page closes one, as it takes a while with TLS."""

    def shutdown(self) -> None:
        with suppress(InvalidState):
            super().shutdown()
        self.transport.close()


class _Forwarded(logging.Handler):
    """Logs Uvicorn's messages at debug level, until it is closed."""

    def __init__(self) -> None:
        super().__init__()
        self._theirs = logging.getLogger("uvicorn.error")
        self._theirs.addHandler(self)
        self._theirs.propagate = False

    def emit(self, record: logging.LogRecord) -> None:
        _log.debug("%s", record.getMessage(), exc_info=record.exc_info)

    def close(self) -> None:
        self._theirs.removeHandler(self)
        super().close()


def _application(source: Source) -> Starlette:
    @asynccontextmanager
    async def lifespan(_app: Starlette) -> AsyncIterator[None]:
        async with source.opened():
            yield

    return Starlette(
        routes=[
            *source.routes(),
            Route("/palette.json", _palette),
            Mount("/", StaticFiles(directory=_PAGE, html=True)),
        ],
        lifespan=lifespan,
    )


async def _palette(_request: Request) -> FileResponse:
    return FileResponse(str(files("hmrsim.drawing") / "palette.json"))


def _bound(host: str, port: int) -> socket.socket:
    try:
        family, _, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)[0]
        both = host == "::" and socket.has_dualstack_ipv6()
        return socket.create_server(address[:2], family=family, dualstack_ipv6=both)
    except OSError as error:
        if error.errno == errno.EADDRINUSE:
            raise PortTaken(f"{_authority(host, port)} is in use; give another with --port, 0 for a free one") from None
        if error.errno == errno.EACCES:
            raise BadOptions(f"--port {port}: permission denied; use 1024 or above") from None
        raise BadOptions(f"--host {host!r} is not an address of this machine: {reason_of(error)}") from None


def _tls(enclave: Enclave | None) -> dict[str, Any]:
    if enclave is None:
        return {}
    folder = enclave.folder
    return {
        "ssl_certfile": folder / CERTIFICATE,
        "ssl_keyfile": folder / KEY,
        "ssl_ca_certs": str(folder / AUTHORITY),
        "ssl_cert_reqs": ssl.CERT_OPTIONAL,
    }


def _url(host: str, port: int, token: str, *, secured: bool) -> str:
    shown = _own_address() if host in _ANY_ADDRESS else host
    return f"http{'s' if secured else ''}://{_authority(shown, port)}/{f'?token={token}' if token else ''}"


def _authority(host: str, port: int) -> str:
    return f"[{host}]:{port}" if ":" in host else f"{host}:{port}"


def _own_address() -> str:
    """Return the address by which other machines reach this one, according to the kernel; nothing is sent."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(_ELSEWHERE)
        except OSError:
            return socket.gethostname()
        return str(probe.getsockname()[0])
