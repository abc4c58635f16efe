"""A running simulator as the source of pages."""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from typing import TYPE_CHECKING, Final

import zenoh
from starlette.responses import JSONResponse, Response
from starlette.routing import Route, WebSocketRoute

from hmrsim_zenoh.view.bridge import Bridge
from hmrsim_zenoh.view.event_log import EventLog
from hmrsim_zenoh.view.feeds import Feeds
from hmrsim_zenoh.view.gets import Gets
from hmrsim_zenoh.view.visitors import anything, visitor_of

if TYPE_CHECKING:
    from starlette.requests import Request
    from starlette.routing import BaseRoute
    from starlette.websockets import WebSocket

    from hmrsim_zenoh.view.visitors import Rights
    from hmrsim_zenoh.wire.keys import Keys

MAX_PAGES: Final = 64
_LOOK_AGAIN: Final = 1.0
_POLICY_VIOLATION: Final = 1008
_TRY_AGAIN_LATER: Final = 1013


class Live:
    """Serves a simulator to pages, within `opened` and in the event loop's thread only.

    Args:
        session: An open session, which the caller closes.
        rights: What visitors may ask; None for everything.

    Attributes:
        alive: Whether the simulator is alive, by its liveliness token.
    """

    feeds: Feeds
    _log: EventLog

    def __init__(self, session: zenoh.Session, keys: Keys, rights: Rights | None = None) -> None:
        self._rights = rights
        self.prefix = keys.prefix
        self.alive = False
        self._session = session
        self._gets = Gets(session, keys.prefix, self._later)
        self._log_key = keys.world("log")
        self._token = keys.alive()
        self._pages: set[Bridge] = set()
        self._loop: asyncio.AbstractEventLoop | None = None

    def routes(self) -> list[BaseRoute]:
        """Return the routes of the source beside the page's files."""
        return [Route("/source", self._source), Route("/log", self._events), WebSocketRoute("/ws", self._serve)]

    @asynccontextmanager
    async def opened(self) -> AsyncIterator[None]:
        """Follow the simulator's token while pages are served."""
        self._loop = asyncio.get_running_loop()
        self.feeds = Feeds(self._session, self.prefix, self._loop)
        self._log = EventLog(self._session, self._log_key)
        handler: zenoh.handlers.Callback[zenoh.Sample] = zenoh.handlers.Callback(
            lambda sample: self._later(self._saw, sample.kind == zenoh.SampleKind.PUT), indirect=False
        )
        subscriber = self._session.liveliness().declare_subscriber(self._token, handler, history=True)
        try:
            yield
        finally:
            subscriber.undeclare()
            self.feeds.close()
            self._log.close()
            self._loop = None

    def _saw(self, alive: bool) -> None:  # noqa: FBT001 - call_soon_threadsafe passes positions
        """Notify the pages that the simulator came or went; `alive` twice in a row means another simulator."""
        self.alive = alive
        if alive:
            self._log.clear()
        for page in self._pages:
            page.set_alive(alive)
        if not alive and self._loop is not None:
            self._loop.call_later(_LOOK_AGAIN, self._look_again)

    def _look_again(self) -> None:
        """Query the token again: Zenoh may have reordered the notifications of a token that came back."""
        if self.alive or self._loop is None:
            return
        handler: zenoh.handlers.Callback[zenoh.Reply] = zenoh.handlers.Callback(
            lambda _reply: self._later(self._came_back), indirect=False
        )
        with suppress(zenoh.ZError):
            self._session.liveliness().get(self._token, handler, timeout=_LOOK_AGAIN)

    def _came_back(self) -> None:
        if not self.alive:
            self._saw(True)

    def _later(self, call: Callable[..., None], *arguments: object) -> None:
        """Schedule a call in the event loop; from Zenoh's threads, also after the loop has ended."""
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
        left = None if visitor.expires == math.inf else max(0.0, visitor.expires - time.time())
        try:
            # What it has subscribed to ends with its certificate, as what it may ask does.
            async with asyncio.timeout(left):
                await page.serve(socket)
        except TimeoutError:
            await socket.close(_POLICY_VIOLATION, f"the certificate of {visitor.name!r} has expired")
        finally:
            self._pages.discard(page)
            self._share()

    def _share(self) -> None:
        for page in self._pages:
            page.share(len(self._pages))
