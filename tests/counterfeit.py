"""A counterfeit simulator, which forwards requests to a real one and changes its answers and publications."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING, Self

import zenoh

from hmrsim_zenoh.wire.keys import Keys
from hmrsim_zenoh.wire.options import SessionOptions
from hmrsim_zenoh.wire.session import open_client, open_server
from tests.patience import PATIENCE

if TYPE_CHECKING:
    from collections.abc import Iterable

Change = Callable[[str, bytes], bytes]
"""Returns the replacement of a payload; the key has no prefix, such as ``_world/info``."""

_PREFIX = "hmrsim/"


class Counterfeit:
    """A counterfeit of a simulator, with the same robots.

    Args:
        real: Where the real one is.
        robots: Whose tokens it has.

    Attributes:
        options: Connection options of a client.
        change: Of what is sent; by default nothing is changed.
    """

    def __init__(self, real: SessionOptions, robots: Iterable[str]) -> None:
        self.change: Change = lambda _key, payload: payload
        self._real = open_client(real)
        self._session, endpoints = open_server(SessionOptions(listen=("tcp/127.0.0.1:0",)))
        self.options = SessionOptions(connect=endpoints)
        keys = Keys()
        liveliness = self._session.liveliness()
        self._tokens = [liveliness.declare_token(keys.alive(robot)) for robot in robots]
        self._tokens.append(liveliness.declare_token(keys.alive()))
        self._queries: queue.SimpleQueue[zenoh.Query | None] = queue.SimpleQueue()
        threading.Thread(target=self._work, daemon=True).start()
        self._queryable = self._session.declare_queryable("**", self._answer, complete=False)
        self._subscriber = self._real.declare_subscriber("**", self._republish)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        self._queries.put(None)
        for session in (self._real, self._session):
            session.close()

    def _answer(self, query: zenoh.Query) -> None:
        if str(query.key_expr).endswith("/get_result"):
            # This request may take as long as its goal; a simulator answers all others in order.
            threading.Thread(target=self._forward, args=(query,), daemon=True).start()
        else:
            self._queries.put(query)

    def _work(self) -> None:
        while (query := self._queries.get()) is not None:
            self._forward(query)

    def _forward(self, query: zenoh.Query) -> None:
        with suppress(zenoh.ZError), query:
            options = {"payload": query.payload, "encoding": query.encoding, "attachment": query.attachment}
            known = {name: value for name, value in options.items() if value is not None}
            for reply in self._real.get(query.selector, timeout=PATIENCE, **known):
                if reply.ok is not None:
                    key, encoding = str(reply.ok.key_expr), reply.ok.encoding
                    query.reply(key, self._changed(key, reply.ok.payload), encoding=encoding)
                elif reply.err is not None:
                    key = str(query.key_expr)
                    query.reply_err(self._changed(key, reply.err.payload), encoding=reply.err.encoding)

    def _republish(self, sample: zenoh.Sample) -> None:
        key = str(sample.key_expr)
        with suppress(zenoh.ZError):
            self._session.put(key, self._changed(key, sample.payload), encoding=sample.encoding)

    def _changed(self, key: str, payload: zenoh.ZBytes) -> bytes:
        return self.change(key.removeprefix(_PREFIX), payload.to_bytes())
