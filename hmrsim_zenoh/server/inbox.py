"""The queue of queries and commands for the simulation, in order of arrival."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple, Protocol

from hmrsim.protocol.inbox import Inbox
from hmrsim_zenoh.server.losses import Losses

if TYPE_CHECKING:
    import zenoh

    from hmrsim.protocol.commands import AnyCommand


class Reader(NamedTuple):
    """The handlers of the queries on a key expression."""

    decode: Callable[[zenoh.Query], list[AnyCommand]]
    refuse: Callable[[zenoh.Query], None]


class QueryInbox(Inbox, ABC):
    """An inbox of the queries on one key expression and on further ones that `serve` adds.

    Args:
        reader: The handlers of the first key expression's queries.
        prepare: Called before a query on any key expression is decoded, and with None when none waits.

    Attributes:
        losses: What of the queries, and of the answers to them, is lost.
        taken: The number of queries that `poll` has taken; that of the latest one.
    """

    def __init__(self, reader: Reader, prepare: Callable[[zenoh.Query | None], None]) -> None:
        super().__init__()
        self.losses = Losses()
        self._reader = reader
        self._prepare = prepare
        self._queries: deque[tuple[Reader, zenoh.Query]] = deque()
        self.taken = 0

    @abstractmethod
    def serve(
        self,
        key_expr: str,
        *,
        decode: Callable[[zenoh.Query], list[AnyCommand]],
        refuse: Callable[[zenoh.Query], None],
        complete: bool = False,
    ) -> None:
        """Serve a further key expression, too, until `leave`; *refuse* also answers queries after `close`."""

    @abstractmethod
    def put_query(self, query: zenoh.Query, reader: Reader | None = None) -> None:
        """Add a query that was not received here; by default it is decoded as those on the first key expression."""

    @property
    def waiting(self) -> bool:
        """Whether a query or a command waits; a query may turn out to hold no command."""
        if not self._commands and not self._queries:
            self._receive()
        return bool(self._commands or self._queries)

    def arrived(self) -> int:
        """Return the number of queries that have arrived: what is found out now is true for each of them."""
        return self.taken + len(self._queries)

    def poll(self) -> AnyCommand | None:
        """Return the next command; None when there is none now, and after `close` when there will be none."""
        while not self._commands:
            # What is received here has its turn, however much other threads add.
            self._receive()
            if not self._queries:
                self._prepare(None)
                return None
            reader, query = self._queries.popleft()
            self.taken += 1
            self._prepare(query)
            for each in self.losses.arrivals(query):
                self._commands.extend(reader.decode(each))
        return self._commands.popleft()

    def leave(self) -> None:
        """Take back what is declared and end all threads; after `close`."""

    def _receive(self) -> bool:
        """Add a query that has come meanwhile, where queries have to be asked for; return whether there is one."""
        return False


class InboxMaker(Protocol):
    """Makes the inbox of a server."""

    def __call__(
        self,
        session: zenoh.Session,
        key_expr: str,
        reader: Reader,
        *,
        wakeup_key: str,
        prepare: Callable[[zenoh.Query | None], None],
    ) -> QueryInbox:
        """Return an inbox.

        Args:
            session: Where to declare the queryable.
            key_expr: What it serves.
            reader: Turns a query into commands, in the simulation's thread, and answers what can't be read; and answers
                a query that there is no room for, or that came after the end, in any thread.
            wakeup_key: A key under *key_expr* of which the reader takes no notice; it wakes the simulation's thread.
            prepare: Called before a query is decoded, and with None when none waits.
        """
