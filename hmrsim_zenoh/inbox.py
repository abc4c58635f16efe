"""Queries on their way to the simulation: one channel for all keys, which the simulation's own thread drains.

As long as time is not paced, no Python runs in Zenoh's threads for a query: the simulation's thread takes it from
the channel, or sleeps in the channel when there is nothing to do. A channel can't be waited for with a timeout,
so that a paced simulation has a second thread carry queries over to a condition that can.
"""

from __future__ import annotations

import logging
import threading
from collections import deque
from typing import TYPE_CHECKING

import zenoh

from hmrsim.gateway import Inbox

if TYPE_CHECKING:
    from collections.abc import Callable

    from hmrsim.gateway import AnyCommand

_log = logging.getLogger(__name__)

_CHANNEL = 16_384
"""Queries that may wait in the channel; Zenoh holds back its peers when it is full."""

_CLOSE_SECONDS = 1.0
"""Wall seconds for refusing what came too late."""


class QueryInbox(Inbox):
    """An inbox that is filled by the queries on one key expression.

    Args:
        session: Where to declare the queryable.
        key_expr: What to answer.
        decode: Turns a query into commands, in the simulation's thread; it answers what can't be read.
        refuse: Answers a query that there is no room for, or that came after the end; called in any thread.
        doorbell: A key under *key_expr* that *decode* ignores; it wakes the simulation's thread.
        most_waiting: Queries that may wait for the simulation's thread.
    """

    def __init__(
        self,
        session: zenoh.Session,
        key_expr: str,
        *,
        decode: Callable[[zenoh.Query], list[AnyCommand]],
        refuse: Callable[[zenoh.Query], None],
        doorbell: str,
        most_waiting: int = 10_000,
    ) -> None:
        super().__init__()
        self._session = session
        self._decode = decode
        self._refuse = refuse
        self._doorbell = doorbell
        self._most_waiting = most_waiting
        self._queries: deque[zenoh.Query] = deque()
        self._asleep = False
        self._carrier: threading.Thread | None = None
        # Not complete: a controller answers for its trees below the same prefix, and Zenoh asks none but one that is.
        self._queryable = session.declare_queryable(key_expr, zenoh.handlers.FifoChannel(_CHANNEL), complete=False)
        self._channel = self._queryable.handler

    @property
    def waiting(self) -> bool:
        """Whether something is there to be taken; it may turn out to hold no command."""
        if not self._commands and not self._queries:
            query = self._next_in_channel()
            if query is not None:
                self._queries.append(query)
        return bool(self._commands or self._queries)

    def poll(self) -> AnyCommand | None:
        """Return the next command; None when there is none now, and after `close` when there will be none."""
        while not self._commands:
            query = self._queries.popleft() if self._queries else self._next_in_channel()
            if query is None:
                return None
            self._commands.extend(self._decode(query))
        return super().poll()

    def put(self, command: AnyCommand) -> None:
        """Add a command and wake the simulation.

        Raises:
            SimulationStopped: The inbox is closed.
        """
        super().put(command)
        self._ring()

    def put_query(self, query: zenoh.Query) -> None:
        """Add a query that came on another key expression."""
        with self._changed:
            taken = len(self._queries) < self._most_waiting and not self._closed
            if taken:
                self._queries.append(query)
                self._changed.notify()
        if taken:
            self._ring()
        else:
            self._refuse(query)

    def wait(self, timeout: float | None) -> None:
        """Return when something is there, the inbox was closed, or *timeout* seconds of wall time have passed."""
        if timeout is None and self._carrier is None:
            self._sleep()
            return
        if self._carrier is None:
            carrier = threading.Thread(target=self._carry, name="hmrsim-queries", daemon=True)
            carrier.start()
            self._carrier = carrier
        with self._changed:
            self._changed.wait_for(lambda: self.waiting or self._closed, timeout)

    def close(self) -> None:
        """Take no more commands, and wake the simulation; what waits in the channel is still there for `poll`."""
        with self._changed:
            if self._closed:
                return
            super().close()
        try:
            self._queryable.undeclare()
        except zenoh.ZError as error:
            _log.debug("undeclaring the queryable: %s", error)
        if self._carrier is not None:
            self._carrier.join(_CLOSE_SECONDS)

    def _sleep(self) -> None:
        """Wait in the channel, without a timeout."""
        self._asleep = True
        try:
            if not (self.waiting or self._closed):
                query = self._recv()
                if query is not None:
                    self._queries.append(query)
        finally:
            self._asleep = False

    def _ring(self) -> None:
        """Wake the simulation's thread if it sleeps in the channel: a query of our own ends its sleep."""
        if self._asleep and not self._closed:
            handler: zenoh.handlers.Callback[zenoh.Reply] = zenoh.handlers.Callback(lambda _reply: None, indirect=False)
            try:
                self._session.get(self._doorbell, handler, timeout=1.0)
            except zenoh.ZError as error:
                _log.debug("the session was closed: %s", error)

    def _carry(self) -> None:
        """Carry queries from the channel to the condition until the channel is closed."""
        while (query := self._recv()) is not None:
            self.put_query(query)

    def _next_in_channel(self) -> zenoh.Query | None:
        """Return a query from the channel, if that is for this thread to empty.

        Of two readers one could overtake the other, and a cancel its goal. Once closed, the channel's end is waited
        for, which is near.
        """
        if self._carrier is not None:
            return None
        return self._recv() if self._closed else self._try_recv()

    def _recv(self) -> zenoh.Query | None:
        try:
            return self._channel.recv()
        except zenoh.ZError:
            return None

    def _try_recv(self) -> zenoh.Query | None:
        try:
            return self._channel.try_recv()
        except zenoh.ZError:
            return None
