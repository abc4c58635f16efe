"""The bridge between one page's WebSocket and Zenoh: it forwards subscriptions and queries for any keys."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Final

import zenoh
from pydantic_core import to_json
from starlette.websockets import WebSocketDisconnect

from hmrsim import __version__
from hmrsim_zenoh.errors import RequestError
from hmrsim_zenoh.view import frames
from hmrsim_zenoh.view.frames import MAX_WAITING, MAX_WAITING_IN_ALL, Outbox

if TYPE_CHECKING:
    from starlette.websockets import WebSocket

    from hmrsim_zenoh.view.access import May
    from hmrsim_zenoh.view.feeds import Feeds

_MAX_REPLY_BYTES: Final = 32 * 2**20
"""Maximum size of the replies to one query, in total."""


@dataclass(frozen=True)
class Replies:
    """The replies to a query.

    Attributes:
        ok: Keys, without the prefix, and payloads.
        errors: The payloads of Zenoh's error replies.
        too_large: Whether replies are missing from *ok*, as they exceeded the maximum size.
    """

    ok: list[tuple[str, bytes]]
    errors: list[bytes]
    too_large: bool


class Gets:
    """Sends queries below a prefix.

    Args:
        call_soon: Schedules a call in the event loop's thread.
    """

    def __init__(self, session: zenoh.Session, prefix: str, call_soon: Callable[[Callable[[], None]], None]) -> None:
        self.prefix = prefix
        self._session = session
        self._call_soon = call_soon

    def get(self, key: str, payload: bytes | None, timeout: float, then: Callable[[Replies], None]) -> None:
        """Send a query; call *then* with all replies after the last one has arrived.

        Raises:
            zenoh.ZError: The session is closed.
        """
        ok: list[tuple[str, bytes]] = []
        errors: list[bytes] = []
        room = _MAX_REPLY_BYTES

        def on_reply(reply: zenoh.Reply) -> None:
            nonlocal room
            if reply.ok is None:
                errors.append(reply.err.payload.to_bytes() if reply.err else b"")
                return
            room -= len(reply.ok.payload)
            if room >= 0:
                ok.append((str(reply.ok.key_expr)[len(self.prefix) + 1 :], reply.ok.payload.to_bytes()))

        handler: zenoh.handlers.Callback[zenoh.Reply] = zenoh.handlers.Callback(
            on_reply, lambda: self._call_soon(lambda: then(Replies(ok, errors, too_large=room < 0))), indirect=False
        )
        # With wildcards, Zenoh's best match would be the simulator alone, without the controllers.
        target = zenoh.QueryTarget.ALL if "*" in key else zenoh.QueryTarget.BEST_MATCHING
        selector = f"{self.prefix}/{key}"
        self._session.get(
            selector, handler, payload=payload, encoding="application/json", timeout=timeout, target=target
        )


MAX_SUBSCRIPTIONS: Final = 64
MAX_GETS: Final = 64
_TIMED_OUT: Final = b"Timeout"
"""Zenoh's own error reply upon a timeout; error replies of a simulator are JSON."""


class Bridge:
    """Serves one page, in the event loop's thread.

    Args:
        may: Returns why the page's visitor may not query a key; empty if the visitor may.
    """

    def __init__(self, gets: Gets, feeds: Feeds, may: May, *, alive: bool) -> None:
        self._may = may
        self._gets = gets
        self._feeds = feeds
        self._alive = alive
        self._outbox = Outbox()
        # The function that ends each subscription.
        self._subscriptions: dict[int, Callable[[], None]] = {}
        self._pending_gets: set[int] = set()
        self._has_frames = asyncio.Event()
        self._has_room = asyncio.Event()
        self._disconnected = False

    async def serve(self, socket: WebSocket) -> None:
        """Serve the page until it disconnects."""
        fields = {"source": "live", "prefix": self._gets.prefix, "version": __version__, "alive": self._alive}
        self.put(frames.frame("hello", **fields))
        sender = asyncio.create_task(self._send(socket))
        try:
            while (message := await socket.receive())["type"] == "websocket.receive":
                self._handle(message.get("text"))
                await self._until_there_is_room()
        finally:
            sender.cancel()
            for end in self._subscriptions.values():
                end()
            self._subscriptions.clear()
            with suppress(asyncio.CancelledError, WebSocketDisconnect):
                await sender

    def put(self, frame: str) -> None:
        """Send a frame to the page."""
        self._outbox.put(frame)
        self._has_frames.set()

    def share(self, pages: int) -> None:
        """Limit the page's waiting samples to its share of the memory for all pages."""
        self._outbox.limit(min(MAX_WAITING, MAX_WAITING_IN_ALL // pages))

    def set_alive(self, alive: bool) -> None:  # noqa: FBT001 - the one value of a setter
        """Notify the page whether the simulator is alive."""
        self._alive = alive
        self.put(frames.frame("alive", alive=alive))

    def _send_samples(self, id_: int, entries: Sequence[tuple[str, str]], lost: bool) -> None:  # noqa: FBT001 - a callback
        self._outbox.add(id_, entries, lost=lost)
        self._has_frames.set()

    async def _send(self, socket: WebSocket) -> None:
        """Send the frames in the outbox as fast as the page reads them, until it disconnects."""
        try:
            while await self._has_frames.wait():
                self._has_frames.clear()
                for frame in self._outbox.drain():
                    await socket.send_text(frame)
                self._has_room.set()
        finally:
            self._disconnected = True
            self._has_room.set()

    async def _until_there_is_room(self) -> None:
        """Wait until the page has read most of its answers, so that it can't make the outbox grow."""
        while self._outbox.crowded and not self._disconnected:
            self._has_room.clear()
            await self._has_room.wait()

    def _handle(self, text: str | None) -> None:
        """Process a request of the page, or send the error."""
        try:
            if text is None:
                raise ValueError("expected a text frame, got a binary one")  # noqa: TRY301 - one place handles errors
            match frames.read(text):
                case frames.Subscribe() as request:
                    self._subscribe(request)
                case frames.Unsubscribe(id=id_):
                    self._unsubscribe(id_)
                case frames.Get() as request:
                    self._get(request)
        except (ValueError, zenoh.ZError) as error:
            self.put(frames.frame("error", error=str(error)))

    def _subscribe(self, request: frames.Subscribe) -> None:
        if request.id in self._subscriptions:
            raise ValueError(f"subscription {request.id} exists already")
        if len(self._subscriptions) >= MAX_SUBSCRIPTIONS:
            raise ValueError(f"there are {MAX_SUBSCRIPTIONS} subscriptions already")
        self._check_key(request.key)
        feed = request.key, request.pause, partial(self._send_samples, request.id)
        self._feeds.subscribe(*feed)
        self._subscriptions[request.id] = partial(self._feeds.unsubscribe, *feed)
        self._outbox.open(request.id, latest=request.latest)

    def _unsubscribe(self, id_: int) -> None:
        if id_ not in self._subscriptions:
            raise ValueError(f"there is no subscription {id_}")
        self._subscriptions.pop(id_)()
        self._outbox.close(id_)

    def _get(self, request: frames.Get) -> None:
        if request.id in self._pending_gets:
            raise ValueError(f"get {request.id} is pending already")
        try:
            if len(self._pending_gets) >= MAX_GETS:
                raise ValueError(f"{MAX_GETS} gets are pending already")  # noqa: TRY301 - one place handles errors
            self._check_key(request.key)
            if denial := self._may(request.key):
                raise ValueError(denial)  # noqa: TRY301 - one place handles errors
            payload = None if request.payload is None else to_json(request.payload)
            self._gets.get(request.key, payload, request.timeout, partial(self._reply, request))
        except (ValueError, zenoh.ZError) as error:
            self.put(frames.failure(request.id, str(error)))
            return
        self._pending_gets.add(request.id)

    def _reply(self, request: frames.Get, replies: Replies) -> None:
        self._pending_gets.discard(request.id)
        if self._outbox.full:
            self.put(frames.failure(request.id, "the page does not read its answers"))
        else:
            self.put(_answer(request, replies))

    def _check_key(self, key: str) -> None:
        """Check a key expression below the prefix.

        Raises:
            ValueError: It is invalid.
        """
        try:
            if "@" in key:
                raise ValueError(f"key {key!r}: keys with '@' are Zenoh's own")
            zenoh.KeyExpr(f"{self._gets.prefix}/{key}")
        except zenoh.ZError:
            raise ValueError(f"{key!r} is not a key expression; chunks are joined by single slashes") from None


def _answer(request: frames.Get, replies: Replies) -> str:
    id_, key = request.id, request.key
    if replies.too_large:
        return frames.failure(id_, f"the answers on {key!r} are too long")
    texts = [frames.embedded(*reply) for reply in replies.ok]
    json_texts = [text for text in texts if text is not None]
    if json_texts or (not replies.errors and not texts and "*" in key):
        return frames.replies(id_, json_texts)
    if texts:
        return frames.failure(id_, f"the answer on {key!r} is not JSON")
    errors = [error for error in replies.errors if error != _TIMED_OUT]
    if errors:
        error = RequestError.from_json(errors[0])
        return frames.failure(id_, str(error), error.details)
    if replies.errors:
        return frames.failure(id_, f"no answer on {key!r} in {request.timeout:g} s")
    return frames.failure(id_, f"nothing answers on {key!r}")
