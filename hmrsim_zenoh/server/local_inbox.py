"""The queue of queries for a simulation in their senders' own process: they are put where they are sent."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from hmrsim.errors import SimulationStopped
from hmrsim_zenoh.server.inbox import QueryInbox, Reader

if TYPE_CHECKING:
    import zenoh

    from hmrsim.protocol.commands import AnyCommand


class LocalInbox(QueryInbox):
    """An inbox that is never waited for: who sends a query has the simulation run."""

    def __init__(
        self,
        session: zenoh.Session,
        key_expr: str,
        reader: Reader,
        *,
        wakeup_key: str,  # noqa: ARG002 - nobody sleeps
        prepare: Callable[[zenoh.Query | None], None] = lambda _query: None,
    ) -> None:
        super().__init__(reader, prepare)
        self._session = session
        self._queryables = [session.declare_queryable(key_expr, self.put_query)]

    def serve(
        self,
        key_expr: str,
        *,
        decode: Callable[[zenoh.Query], list[AnyCommand]],
        refuse: Callable[[zenoh.Query], None],
        complete: bool = False,  # noqa: ARG002 - there is no network
    ) -> None:
        """Serve a further key expression, too."""
        reader = Reader(decode, refuse)
        self._queryables.append(self._session.declare_queryable(key_expr, lambda query: self.put_query(query, reader)))

    def put_query(self, query: zenoh.Query, reader: Reader | None = None) -> None:
        """Add a query."""
        reader = reader or self._reader
        if self._closed:
            reader.refuse(query)
        else:
            self._queries.append((reader, query))

    def put(self, command: AnyCommand) -> None:
        """Add a command.

        Raises:
            SimulationStopped: The inbox is closed.
        """
        if self._closed:
            raise SimulationStopped("the simulation has ended")
        self._commands.append(command)

    def poll(self) -> AnyCommand | None:
        """Return the next command; None when there is none now."""
        if self._commands:
            return self._commands.popleft()
        return super().poll() if self._queries else None

    @property
    def waiting(self) -> bool:
        """Whether a query or a command waits."""
        return bool(self._commands or self._queries)

    def wait(self, timeout: float | None) -> None:  # noqa: ARG002 - as others
        """Prepare for the next query, and return."""
        self._prepare(None)

    def leave(self) -> None:
        """Take back what is declared."""
        for queryable in self._queryables:
            queryable.undeclare()
