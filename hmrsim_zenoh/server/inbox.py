"""The inbox of the simulation: queries and commands in order of arrival.

Over Zenoh each key expression has a channel of queries, and the simulation thread drains it. No Python runs in Zenoh's
threads for a query: the simulation thread takes it from the channel, or blocks on the first channel when it is idle. A
channel has no wait with a timeout, and a thread can block on one only. Where time is paced, and for further channels,
a second thread blocks on the channel in place of the simulation thread, forwards one query to a condition variable,
and leaves the channel to the simulation thread until its next wait: while that thread computes, Python lets another
one run only every 5 ms.
"""

from __future__ import annotations

import logging
import threading
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Sequence
from queue import SimpleQueue
from typing import TYPE_CHECKING, NamedTuple

import zenoh

from hmrsim.protocol.commands import Inbox
from hmrsim_zenoh.server.losses import Losses

if TYPE_CHECKING:
    from hmrsim.protocol.commands import AnyCommand

    Channel = zenoh.handlers.Handler[zenoh.Query]


_log = logging.getLogger(__name__)

_CHANNEL = 16_384
"""The channel's capacity in queries; Zenoh applies backpressure to its peers when it is full."""

_BATCH = 256
"""Queries that are taken from the channel at once."""

_CLOSE_SECONDS = 1.0
"""Wall seconds for refusing late queries."""


class Reader(NamedTuple):
    """The handlers of the queries on a key expression."""

    decode: Callable[[zenoh.Query], list[AnyCommand]]
    refuse: Callable[[zenoh.Query], None]


class QueryInbox(Inbox, ABC):
    """An inbox of the queries on a key expression, from `open` on.

    Attributes:
        losses: Decides which answers are lost, and which queries arrive twice.
        taken: The number of queries that `poll` has taken.
    """

    _reader: Reader
    """The reader of the first key expression."""

    def __init__(self) -> None:
        super().__init__()
        self.losses = Losses()
        self._queries: deque[tuple[Reader, zenoh.Query]] = deque()
        self._preparation: Callable[[zenoh.Query | None], bool] | None = None
        self.taken = 0

    @abstractmethod
    def open(self, session: zenoh.Session, key_expr: str, reader: Reader, *, wakeup_key: str) -> None:
        """Take the queries on a key expression from now on.

        Args:
            session: Where to declare the queryable.
            key_expr: The keys that it serves.
            reader: Decodes queries, in the simulation's thread, and refuses those that are too many or too late, in any
                thread.
            wakeup_key: A key under *key_expr* that the reader ignores; a query on it wakes the simulation's thread.
        """

    @abstractmethod
    def put_query(self, query: zenoh.Query) -> None:
        """Add a query of another queryable, to be decoded like those on the key expression."""

    def prepare(self, call: Callable[[zenoh.Query | None], bool]) -> None:
        """Call a function before each query is decoded, and with None if none waits, until it returns True."""
        self._preparation = call

    @property
    def waiting(self) -> bool:
        """Return whether a query or a command waits; a query may turn out to hold no command."""
        return bool(self._commands or self._queries) or self._receive()

    def arrived(self) -> int:
        """Return how many queries have arrived so far, including those taken."""
        return self.taken + len(self._queries)

    def poll(self) -> AnyCommand | None:
        """Return the next command; None when there is none now, and after `close` when there will be none."""
        while not self._commands:
            # Queries that arrive here get their turn, however many commands other threads add.
            if not self._receive():
                if self._preparation is not None:
                    self._prepare(None)
                return None
            reader, query = self._queries.popleft()
            self.taken += 1
            if self._preparation is not None:
                self._prepare(query)
            losses, decode = self.losses, reader.decode
            self._commands.extend(losses.arrive(query, decode) if losses.active else decode(query))
        return self._commands.popleft()

    def _prepare(self, query: zenoh.Query | None) -> None:
        if self._preparation is not None and self._preparation(query):
            self._preparation = None

    def leave(self) -> None:
        """Undeclare the queryables and end all threads; called after `close`."""

    def _receive(self) -> bool:
        """Add the queries that have arrived, if queries have to be polled; return whether any waits."""
        return bool(self._queries)


class _LentChannel:
    """A channel of queries, which either the simulation thread reads or another one, while the channel is lent to it.

    With two readers a cancel request could overtake its goal.

    Args:
        add: Adds a query in the other thread; returns whether the channel returns to the simulation thread.

    Attributes:
        lent: Whether the other thread reads it.
        recv: Waits for the next query and returns it; raises `zenoh.ZError` once the channel is closed and empty.
        try_recv: The same without waiting; returns None if there is no query now.
    """

    def __init__(
        self, queryable: zenoh.Queryable[Channel], reader: Reader, add: Callable[[zenoh.Query, _LentChannel], bool]
    ) -> None:
        self.reader = reader
        self.lent = False
        self.recv, self.try_recv = queryable.handler.recv, queryable.handler.try_recv
        self._queryable = queryable
        self._add = add
        # The other thread reads when it gets True, and ends when it gets False.
        self._orders: SimpleQueue[bool] = SimpleQueue()
        self._thread: threading.Thread | None = None

    def lend(self) -> None:
        """Lend the channel to the other thread until it has added a query."""
        if self.lent:
            return
        self.lent = True
        self._orders.put(True)
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name="hmrsim-queries", daemon=True)
            self._thread.start()

    def close(self) -> None:
        """Undeclare the queryable, and end the other thread."""
        try:
            self._queryable.undeclare()
        except zenoh.ZError as error:
            _log.debug("undeclaring a queryable: %s", error)
        if self._thread is not None:
            self._orders.put(False)
            self._thread.join(_CLOSE_SECONDS)

    def _run(self) -> None:
        while self._orders.get():
            added = False
            while not added:
                try:
                    query = self.recv()
                except zenoh.ZError:
                    return
                added = self._add(query, self)


class ChannelInbox(QueryInbox):
    """An inbox of the queries that come over Zenoh, on one key expression and on further ones that `serve` adds.

    Args:
        max_waiting: Queries that may wait for the simulation thread.
    """

    _session: zenoh.Session
    _wakeup_key: str

    def __init__(self, *, max_waiting: int = 10_000) -> None:
        super().__init__()
        self._max_waiting = max_waiting
        self._asleep = False
        self._channels: list[_LentChannel] = []

    def open(self, session: zenoh.Session, key_expr: str, reader: Reader, *, wakeup_key: str) -> None:
        """Take the queries on a key expression from now on."""
        self._session, self._reader, self._wakeup_key = session, reader, wakeup_key
        # Not complete: Zenoh would not query a controller that serves its trees below the same prefix.
        self.serve(key_expr, reader, complete=False)

    def serve(self, key_expr: str, reader: Reader, *, complete: bool) -> None:
        """Take the queries on a further key expression until `leave`; they are also refused after `close`."""
        queryable = self._session.declare_queryable(key_expr, zenoh.handlers.FifoChannel(_CHANNEL), complete=complete)
        self._channels.append(_LentChannel(queryable, reader, self._add_forwarded))

    def put(self, command: AnyCommand) -> None:
        """Add a command and wake the simulation thread.

        Raises:
            SimulationStopped: The inbox is closed.
        """
        super().put(command)
        self._wake()

    def put_query(self, query: zenoh.Query) -> None:
        """Add a query of another queryable, to be decoded like those on the key expression."""
        with self._changed:
            taken = self._add(query, self._reader)
        if taken:
            self._wake()
        else:
            self._reader.refuse(query)

    def wait(self, timeout: float | None) -> None:
        """Wait for a query or command, for the inbox to be closed, or for *timeout* wall seconds."""
        if self._preparation is not None:
            self._prepare(None)
        blocks = timeout is None and not self._channels[0].lent
        if blocks and len(self._channels) == 1:
            self._sleep()
            return
        with self._changed:
            if not self.waiting and not self.closed:
                for channel in self._channels[1:] if blocks else self._channels:
                    channel.lend()
            if not blocks:
                self._changed.wait_for(lambda: self.waiting or self.closed, timeout)
        if blocks:
            self._sleep()

    def close(self) -> None:
        """Close the inbox and wake the simulation thread; `poll` still returns the queries that have arrived."""
        first, *further = self._channels
        with self._changed:
            if self.closed:
                return
            if further:
                self._receive(further)
            super().close()
            # From now on the other threads refuse the queries.
            for channel in further:
                channel.lend()
        first.close()

    def leave(self) -> None:
        """Undeclare the queryables and end all threads; after `close`."""
        for channel in self._channels[1:]:
            channel.close()

    def _sleep(self) -> None:
        """Block on the first channel, without a timeout."""
        self._asleep = True
        try:
            if not (self._commands or self._queries or self.closed):
                self._queries.append((self._reader, self._channels[0].recv()))
        except zenoh.ZError:
            # The channel is closed and empty.
            return
        finally:
            self._asleep = False

    def _wake(self) -> None:
        """Wake the simulation thread if it blocks on the channel, by a query on the wakeup key."""
        if self._asleep and not self.closed:
            handler: zenoh.handlers.Callback[zenoh.Reply] = zenoh.handlers.Callback(lambda _reply: None, indirect=False)
            try:
                self._session.get(self._wakeup_key, handler, timeout=1.0)
            except zenoh.ZError as error:
                _log.debug("the session was closed: %s", error)

    def _add(self, query: zenoh.Query, reader: Reader) -> bool:
        """Add a query, with the lock held; return False if too many wait, or the inbox is closed."""
        if len(self._queries) >= self._max_waiting or self.closed:
            return False
        self._queries.append((reader, query))
        self._changed.notify()
        return True

    def _add_forwarded(self, query: zenoh.Query, channel: _LentChannel) -> bool:
        """Add a query of a lent channel, which then returns to the simulation thread; or refuse the query."""
        with self._changed:
            taken = self._add(query, channel.reader)
            channel.lent = not taken
        if taken:
            self._wake()
        else:
            channel.reader.refuse(query)
        return taken

    def _receive(self, channels: Sequence[_LentChannel] | None = None) -> bool:
        """Take the queries that have arrived, on all or some of the channels; return whether any waits.

        After closing, this waits for the first channel's end, which is near.
        """
        queries = self._queries
        if len(queries) < _BATCH:
            for channel in channels or self._channels:
                take = channel.recv if self.closed and channel is self._channels[0] else channel.try_recv
                try:
                    for _ in range(0 if channel.lent else _BATCH):
                        if (query := take()) is None:
                            break
                        queries.append((channel.reader, query))
                except zenoh.ZError:
                    # The channel is closed and empty.
                    continue
        return bool(queries)
