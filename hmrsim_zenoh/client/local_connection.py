"""The connection to a simulator in this process: commands go to its inbox, and answers come from its sinks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any

import zenoh

from hmrsim.protocol.commands import CallService
from hmrsim_zenoh.client.connection import Ask, take_within
from hmrsim_zenoh.errors import ClientClosed
from hmrsim_zenoh.loopback.session import Pending

if TYPE_CHECKING:
    from hmrsim.protocol.commands import AnyCommand, SendGoal
    from hmrsim_zenoh.client.connection import ActionTarget, Answer, Asked, GoalCommand, Listener, ReadInfo
    from hmrsim_zenoh.errors import Denied
    from hmrsim_zenoh.loopback.session import LoopbackSession


class LocalCall(Pending):
    """A request whose answer has usually arrived when the call returns.

    Attributes:
        answer: The answer; None before it arrives, and if it was lost.
    """

    __slots__ = ("_bell", "_ended", "answer")

    def __init__(self, session: LoopbackSession) -> None:
        # As the base class does, in place of a call for each advance.
        self.session, self.may_be_lost = session, False
        self.answer: Answer = None
        self._ended = False
        self._bell: SimpleQueue[None] | None = None

    def take(self, answer: Answer) -> None:
        """Take the answer, unless the session was cut off; from any thread."""
        if not self._ended and self.session.error is None:
            self.answer, self._ended = answer, True
            if self._bell is not None:
                self._bell.put(None)

    def give_up(self) -> None:
        """End the request without an answer; from any thread."""
        self.take(None)

    def wait(self, timeout: float) -> bool:
        """Return whether there is an answer, or will be none, within *timeout* wall seconds."""
        if self._ended:
            return True
        # Another thread has to advance time first.
        self._bell = self._bell or SimpleQueue()
        with suppress(Empty):
            take_within(self._bell, timeout)
        return self._ended


class _Sent(Pending):
    """A command whose answer goes to a function."""

    __slots__ = ("_then",)

    def __init__(self, session: LoopbackSession, then: Callable[[Answer], None]) -> None:
        super().__init__(session)
        self._then = then

    def take(self, answer: Answer) -> None:
        """Pass the answer on, unless the session was cut off."""
        if self.session.error is None:
            self._then(answer)


class LocalConnection:
    """A `Connection` within one process.

    Args:
        on_closed: Called when the session turns out to be closed.
    """

    ordered = False
    in_process = True

    def __init__(self, session: LoopbackSession, on_closed: Callable[[], None]) -> None:
        self._session = session
        self._on_closed = on_closed

    def send(
        self,
        _target: ActionTarget,
        command: GoalCommand,
        then: Callable[[Answer], None],
        *,
        timeout: float,  # noqa: ARG002 - the answer comes at once
        read: bool = True,  # noqa: ARG002 - there is nothing to read
        ended: bool = False,  # noqa: ARG002 - there is no event to wait for
    ) -> None:
        """Send a command to the simulator's inbox."""
        self._submit(command, _Sent(self._session, then))

    def execute(
        self,
        _target: ActionTarget,
        command: SendGoal,
        *,
        timeout: float,  # noqa: ARG002 - as above
        on_answer: Callable[[Answer], None],
        on_end: Callable[[], None],
        read: bool = True,  # noqa: ARG002 - as above
    ) -> None:
        """Send a goal; its result is to be asked for."""
        self._submit(command, _Sent(self._session, on_answer))
        on_end()

    def listen(self, target: ActionTarget, listener: Listener) -> None:
        """Do nothing: in one process time moves in lockstep only, which delivers the feedback."""

    def call(self, command: Asked, *, timeout: float) -> LocalCall:  # noqa: ARG002 - as above
        """Send a command for whose answer a thread waits."""
        call = LocalCall(self._session)
        sent = CallService(command.service, command.request) if isinstance(command, Ask) else command
        try:
            self._session.submit(sent, call)
        except zenoh.ZError:
            self._give_up(call)
        return call

    def token(self) -> str:
        """Return a text that no other connection has."""
        return str(self._session.new_timestamp())

    def fitting(self, commands: Sequence[Any]) -> int:
        """Return how many of some commands go with one advance: all."""
        return len(commands)

    def announce(self, name: str) -> Callable[[], None]:
        """Announce a participant; return a function that withdraws the announcement."""
        try:
            return self._session.announce(name)
        except zenoh.ZError:
            raise ClientClosed("the client is closed") from None

    def follow(self, on_change: Callable[[bool], None]) -> Callable[[], None]:
        """Report whether the simulator is alive, now and whenever that changes; return a function to stop that."""
        if self._session.is_closed():
            raise ClientClosed("the client is closed")
        return self._session.simulation.follow(on_change)

    def look(self, on_alive: Callable[[], None], then: Callable[[], None], *, timeout: float) -> None:  # noqa: ARG002
        """Call a function if the simulator is alive, and then the other."""
        self._session.simulation.follow(lambda alive: on_alive() if alive else None)()
        then()

    def close(self) -> None:
        """Do nothing: there are no listeners."""

    def denial(self, _target: ActionTarget, _command: GoalCommand) -> Denied | None:
        """Return None: there is no access control."""
        return None

    def _submit(self, command: AnyCommand | ReadInfo, pending: Pending) -> None:
        try:
            self._session.submit(command, pending)
        except zenoh.ZError:
            self._give_up(pending)

    def _give_up(self, pending: Pending) -> None:
        self._on_closed()
        pending.take(None)
