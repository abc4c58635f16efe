"""Queries on their way to the simulation: one channel for all keys, which the simulation's own thread drains.

As long as time is not paced, no Python runs in Zenoh's threads for a query: the simulation's thread takes it from
the channel, or sleeps in the channel when there is nothing to do. A channel can't be waited for with a timeout,
so that a paced simulation has a second thread carry queries over to a condition that can.

Further key expressions have a channel and a thread each, which carries their queries over always: the simulation's
thread can sleep in one channel only. That costs a query a tenth of a millisecond where time is not paced.
"""

from __future__ import annotations

import logging
import threading
from collections import deque
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import zenoh

from hmrsim.protocol.inbox import Inbox

if TYPE_CHECKING:
    from collections.abc import Callable

    from hmrsim.protocol.commands import AnyCommand

    Channel = zenoh.handlers.Handler[zenoh.Query]

_log = logging.getLogger(__name__)

_CHANNEL = 16_384
"""Queries that may wait in the channel; Zenoh holds back its peers when it is full."""

_CLOSE_SECONDS = 1.0
"""Wall seconds for refusing what came too late."""


class _Reader(NamedTuple):
    """Who understands the queries on a key expression.

    Attributes:
        decode: Turns a query into commands, in the simulation's thread; it answers what can't be read.
        refuse: Answers a query that there is no room for, or that came after the end; called in any thread.
    """

    decode: Callable[[zenoh.Query], list[AnyCommand]]
    refuse: Callable[[zenoh.Query], None]


class QueryInbox(Inbox):
    """An inbox that is filled by the queries on one key expression, and on others that `serve` adds.

    Args:
        session: Where to declare the queryable.
        key_expr: What to answer.
        decode: Turns a query into commands, in the simulation's thread; it answers what can't be read.
        refuse: Answers a query that there is no room for, or that came after the end; called in any thread.
        wakeup_key: A key under *key_expr* that *decode* ignores; it wakes the simulation's thread.
        most_waiting: Queries that may wait for the simulation's thread.
    """

    def __init__(
        self,
        session: zenoh.Session,
        key_expr: str,
        *,
        decode: Callable[[zenoh.Query], list[AnyCommand]],
        refuse: Callable[[zenoh.Query], None],
        wakeup_key: str,
        most_waiting: int = 10_000,
    ) -> None:
        super().__init__()
        self._session = session
        self._reader = _Reader(decode, refuse)
        self._wakeup_key = wakeup_key
        self._most_waiting = most_waiting
        self._queries: deque[tuple[_Reader, zenoh.Query]] = deque()
        self._asleep = False
        self._carrier: threading.Thread | None = None
        # Not complete: a controller answers for its trees below the same prefix, and Zenoh asks none but one that is.
        self._queryable = session.declare_queryable(key_expr, zenoh.handlers.FifoChannel(_CHANNEL), complete=False)
        self._channel = self._queryable.handler
        self._further: list[tuple[zenoh.Queryable[Channel], threading.Thread]] = []

    def serve(
        self,
        key_expr: str,
        *,
        decode: Callable[[zenoh.Query], list[AnyCommand]],
        refuse: Callable[[zenoh.Query], None],
        complete: bool = False,
    ) -> None:
        """Take the queries on a further key expression, too; they are answered until `leave`.

        Args:
            key_expr: What to answer.
            decode: As above.
            refuse: As above; also answers what comes after `close`.
            complete: Whether we say that we have all that there is.
        """
        queryable = self._session.declare_queryable(key_expr, zenoh.handlers.FifoChannel(_CHANNEL), complete=complete)
        self._further.append((queryable, self._start_carrier(queryable.handler, _Reader(decode, refuse))))

    @property
    def waiting(self) -> bool:
        """Whether something is there to be taken; it may turn out to hold no command."""
        if not self._commands and not self._queries:
            self._take_over()
        return bool(self._commands or self._queries)

    def poll(self) -> AnyCommand | None:
        """Return the next command; None when there is none now, and after `close` when there will be none."""
        while not self._commands:
            # Whatever others carry over, the channel has its turn.
            self._take_over()
            if not self._queries:
                return None
            reader, query = self._queries.popleft()
            self._commands.extend(reader.decode(query))
        return super().poll()

    def put(self, command: AnyCommand) -> None:
        """Add a command and wake the simulation.

        Raises:
            SimulationStopped: The inbox is closed.
        """
        super().put(command)
        self._ring()

    def put_query(self, query: zenoh.Query, reader: _Reader | None = None) -> None:
        """Add a query that came another way; it is read as those on our own key expression if nothing else is said."""
        reader = reader or self._reader
        with self._changed:
            taken = len(self._queries) < self._most_waiting and not self._closed
            if taken:
                self._queries.append((reader, query))
                self._changed.notify()
        if taken:
            self._ring()
        else:
            reader.refuse(query)

    def wait(self, timeout: float | None) -> None:
        """Return when something is there, the inbox was closed, or *timeout* seconds of wall time have passed."""
        if timeout is None and self._carrier is None:
            self._sleep()
            return
        if self._carrier is None:
            self._carrier = self._start_carrier(self._channel, self._reader)
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

    def leave(self) -> None:
        """Answer nobody any more, and end all threads; after `close`."""
        for queryable, forwarder in self._further:
            try:
                queryable.undeclare()
            except zenoh.ZError as error:
                _log.debug("undeclaring a queryable: %s", error)
            forwarder.join(_CLOSE_SECONDS)

    def _sleep(self) -> None:
        """Wait in the channel, without a timeout."""
        self._asleep = True
        try:
            if not (self.waiting or self._closed):
                query = _recv(self._channel)
                if query is not None:
                    self._queries.append((self._reader, query))
        finally:
            self._asleep = False

    def _ring(self) -> None:
        """Wake the simulation's thread if it sleeps in the channel: a query of our own ends its sleep."""
        if self._asleep and not self._closed:
            handler: zenoh.handlers.Callback[zenoh.Reply] = zenoh.handlers.Callback(lambda _reply: None, indirect=False)
            try:
                self._session.get(self._wakeup_key, handler, timeout=1.0)
            except zenoh.ZError as error:
                _log.debug("the session was closed: %s", error)

    def _start_carrier(self, channel: Channel, reader: _Reader) -> threading.Thread:
        forwarder = threading.Thread(target=partial(self._forward, channel, reader), name="hmrsim-queries", daemon=True)
        forwarder.start()
        return forwarder

    def _forward(self, channel: Channel, reader: _Reader) -> None:
        """Carry queries from a channel to the condition until the channel is closed."""
        while (query := _recv(channel)) is not None:
            self.put_query(query, reader)

    def _take_over(self) -> None:
        """Take the next query from the channel, if there is one and that is for this thread to empty.

        Of two readers one could overtake the other, and a cancel its goal. Once closed, the channel's end is waited
        for, which is near.
        """
        if self._carrier is None:
            query = _recv(self._channel) if self._closed else _try_recv(self._channel)
            if query is not None:
                self._queries.append((self._reader, query))


def _recv(channel: Channel) -> zenoh.Query | None:
    try:
        return channel.recv()
    except zenoh.ZError:
        return None


def _try_recv(channel: Channel) -> zenoh.Query | None:
    try:
        return channel.try_recv()
    except zenoh.ZError:
        return None
