"""The sources of pages: a running simulator, or a recording."""

from __future__ import annotations

import asyncio
import logging
import math
import time
import zlib
from collections.abc import AsyncIterator, Callable, Iterable, Iterator
from contextlib import asynccontextmanager, suppress
from typing import TYPE_CHECKING, Any, Final, Protocol

import zenoh
from pydantic import ValidationError
from pydantic_core import to_json
from starlette.responses import JSONResponse, Response, StreamingResponse
from starlette.routing import Route, WebSocketRoute

from hmrsim.errors import HmrsimError
from hmrsim.world.model import World
from hmrsim.world_checks.resolved import shown
from hmrsim_zenoh.view.access import anything, visitor_of
from hmrsim_zenoh.view.bridge import Bridge, Gets
from hmrsim_zenoh.view.feeds import EventLog, Feeds

if TYPE_CHECKING:
    from starlette.requests import Request
    from starlette.routing import BaseRoute
    from starlette.websockets import WebSocket

    from hmrsim_zenoh.view.access import VisitorRights
    from hmrsim_zenoh.wire.keys import Keys

MAX_PAGES: Final = 64
_RECHECK_SECONDS: Final = 1.0
"""Wall seconds after which the token of a simulator that is gone is queried again, and of that query."""
_POLICY_VIOLATION: Final = 1008
_TRY_AGAIN_LATER: Final = 1013


class Live:
    """Serves a simulator to pages; only within `opened`, in the event loop's thread.

    Args:
        session: An open session, which the caller closes.
        rights: The rights of visitors; None for all rights.

    Attributes:
        alive: Whether the simulator is alive, by its liveliness token.
    """

    feeds: Feeds
    _log: EventLog

    def __init__(self, session: zenoh.Session, keys: Keys, rights: VisitorRights | None = None) -> None:
        self._rights = rights
        self.prefix = keys.prefix
        self.alive = False
        self._session = session
        self._gets = Gets(session, keys.prefix, self._call_soon)
        self._log_key = keys.world("log")
        self._token = keys.alive()
        self._pages: set[Bridge] = set()
        self._loop: asyncio.AbstractEventLoop | None = None

    def routes(self) -> list[BaseRoute]:
        """Return the routes of the source, besides the page's files."""
        return [Route("/source", self._source), Route("/log", self._events), WebSocketRoute("/ws", self._serve)]

    @asynccontextmanager
    async def opened(self) -> AsyncIterator[None]:
        """Follow the simulator's token while pages are served."""
        self._loop = asyncio.get_running_loop()
        self.feeds = Feeds(self._session, self.prefix, self._loop)
        self._log = EventLog(self._session, self._log_key)
        handler: zenoh.handlers.Callback[zenoh.Sample] = zenoh.handlers.Callback(
            lambda sample: self._call_soon(self._set_alive, sample.kind == zenoh.SampleKind.PUT), indirect=False
        )
        subscriber = self._session.liveliness().declare_subscriber(self._token, handler, history=True)
        try:
            yield
        finally:
            subscriber.undeclare()
            self.feeds.close()
            self._log.close()
            self._loop = None

    def _set_alive(self, alive: bool) -> None:  # noqa: FBT001 - call_soon_threadsafe passes positions
        """Notify the pages that the simulator came or went; coming twice in a row means another simulator."""
        self.alive = alive
        if alive:
            self._log.clear()
        for page in self._pages:
            page.set_alive(alive)
        if not alive and self._loop is not None:
            self._loop.call_later(_RECHECK_SECONDS, self._recheck)

    def _recheck(self) -> None:
        """Query the token again, as Zenoh may have reordered the notifications of a restart."""
        if self.alive or self._loop is None:
            return
        handler: zenoh.handlers.Callback[zenoh.Reply] = zenoh.handlers.Callback(
            lambda _reply: self._call_soon(self._on_recheck), indirect=False
        )
        with suppress(zenoh.ZError):
            self._session.liveliness().get(self._token, handler, timeout=_RECHECK_SECONDS)

    def _on_recheck(self) -> None:
        if not self.alive:
            self._set_alive(True)

    def _call_soon(self, call: Callable[..., None], *arguments: object) -> None:
        """Schedule a call in the event loop, from any thread; ignore it after the loop has ended."""
        loop = self._loop
        if loop is not None:
            with suppress(RuntimeError):
                loop.call_soon_threadsafe(call, *arguments)

    async def _source(self, _request: Request) -> JSONResponse:
        return JSONResponse({"kind": "live"})

    async def _events(self, _request: Request) -> Response:
        return Response(self._log.json(), media_type="application/json")

    async def _serve(self, socket: WebSocket) -> None:
        await socket.accept()
        if len(self._pages) >= MAX_PAGES:
            await socket.close(_TRY_AGAIN_LATER, f"there are {MAX_PAGES} pages already")
            return
        visitor = visitor_of(socket.scope)
        may = anything if self._rights is None else self._rights.of(visitor)
        page = Bridge(self._gets, self.feeds, may, alive=self.alive)
        self._pages.add(page)
        self._share()
        remaining = None if visitor.expires == math.inf else max(0.0, visitor.expires - time.time())
        try:
            # Subscriptions end when the certificate expires, as queries do.
            async with asyncio.timeout(remaining):
                await page.serve(socket)
        except TimeoutError:
            await socket.close(_POLICY_VIOLATION, f"the certificate of {visitor.name!r} has expired")
        finally:
            self._pages.discard(page)
            self._share()

    def _share(self) -> None:
        for page in self._pages:
            page.share(len(self._pages))


_CHUNK: Final = 256 * 1024
_GZIP_WBITS: Final = 31
"""zlib's number for a window of 32 kB with a gzip header."""
_GZIP_LEVEL: Final = 5

_log = logging.getLogger(__name__)


class Recording(Protocol):
    """The recording that a page shows.

    Attributes:
        begin: Simulated nanoseconds of the first sample.
        end: Simulated nanoseconds of the last sample.
        truncated: Whether the end is missing, as after a crash.
    """

    begin: int
    end: int
    truncated: bool

    @property
    def name(self) -> str:
        """The name of the file."""

    def samples(self) -> Iterable[tuple[int, str, Any]]:
        """Return nanoseconds, key and payload of each sample, in order."""


class Recorded:
    """Serves a whole recording to pages, which play it back."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording

    def routes(self) -> list[BaseRoute]:
        """Return the routes of the source, besides the page's files."""
        return [Route("/source", self._source), Route("/recording", self._samples)]

    @asynccontextmanager
    async def opened(self) -> AsyncIterator[None]:
        """Do nothing: a recording does not change."""
        yield

    async def _source(self, _request: Request) -> Response:
        recording = self._recording
        return JSONResponse(
            {
                "kind": "recording",
                "name": recording.name,
                "begin": recording.begin,
                "end": recording.end,
                "truncated": recording.truncated,
            }
        )

    async def _samples(self, request: Request) -> Response:
        packed = "gzip" in request.headers.get("accept-encoding", "")
        chunks = _in_chunks(self._lines())
        return StreamingResponse(
            _gzip(chunks) if packed else chunks,
            media_type="application/x-ndjson",
            headers={"Vary": "Accept-Encoding", **({"Content-Encoding": "gzip"} if packed else {})},
        )

    def _lines(self) -> Iterator[bytes]:
        """Yield a line for each sample, up to the first unreadable one."""
        samples = self._recording.samples()
        try:
            for at, key, payload in samples:
                if key == "_world/world":
                    sample = (at, "_world/view", shown(World.model_validate(payload)))
                else:
                    sample = (at, key, payload)
                yield to_json(sample, inf_nan_mode="null") + b"\n"
        except (ValidationError, KeyError) as error:
            _log.warning("a world can't be read: %s; only earlier samples are shown", str(error).partition("\n")[0])
        except HmrsimError as error:
            _log.warning("%s; only earlier samples are shown", error)


def _in_chunks(lines: Iterable[bytes]) -> Iterator[bytes]:
    """Join lines into chunks, as each chunk passes through a thread, which takes longer than encoding a line."""
    chunk = bytearray()
    for line in lines:
        chunk += line
        if len(chunk) >= _CHUNK:
            yield bytes(chunk)
            chunk.clear()
    yield bytes(chunk)


def _gzip(chunks: Iterable[bytes]) -> Iterator[bytes]:
    packer = zlib.compressobj(_GZIP_LEVEL, wbits=_GZIP_WBITS)
    for chunk in chunks:
        yield packer.compress(chunk)
    yield packer.flush()
