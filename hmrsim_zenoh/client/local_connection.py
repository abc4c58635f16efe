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

if TYPE_CHECKING:
    from hmrsim.protocol.commands import AnyCommand, SendGoal
    from hmrsim_zenoh.client.connection import ActionTarget, Answer, Asked, GoalCommand, Listener, ReadInfo
    from hmrsim_zenoh.errors import Denied
    from hmrsim_zenoh.loopback.session import LoopbackSession
    from hmrsim_zenoh.wire.keys import Keys


class LocalCall:
    """A request whose answer has usually arrived when the call returns.

    Attributes:
        answer: The answer; None before it arrives, and if it was lost.
    """

    def __init__(self) -> None:
        self.answer: Answer = None
        self._ended = False
        self._bell: SimpleQueue[None] | None = None

    def take(self, answer: Answer) -> None:
        """Take the answer; from any thread."""
        if not self._ended:
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


class LocalConnection:
    """A `Connection` within one process.

    Args:
        on_closed: Called when the session turns out to be closed.
    """

    ordered = False
    in_process = True

    def __init__(self, session: LoopbackSession, keys: Keys, on_closed: Callable[[], None]) -> None:
        self._session = session
        self._keys = keys
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
        self._send(command, then)

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
        self._send(command, on_answer)
        on_end()

    def listen(self, target: ActionTarget, listener: Listener) -> None:
        """Do nothing: in one process time moves in lockstep only, which delivers the feedback."""

    def call(self, command: Asked, *, timeout: float) -> LocalCall:  # noqa: ARG002 - as above
        """Send a command for whose answer a thread waits."""
        call = LocalCall()
        self._send(CallService(command.service, command.request) if isinstance(command, Ask) else command, call.take)
        return call

    def token(self) -> str:
        """Return a text that no other connection has."""
        return str(self._session.new_timestamp())

    def fitting(self, commands: Sequence[Any]) -> int:
        """Return how many of some commands go with one advance: all."""
        return len(commands)

    def announce(self, name: str) -> Callable[[], None]:
        """Declare the liveliness token of a participant; return a function that undeclares it."""
        try:
            token = self._session.liveliness().declare_token(self._keys.participant(name))
        except zenoh.ZError:
            raise ClientClosed("the client is closed") from None
        return token.undeclare

    def close(self) -> None:
        """Do nothing: there are no listeners."""

    def denial(self, _target: ActionTarget, _command: GoalCommand) -> Denied | None:
        """Return None: there is no access control."""
        return None

    def _send(self, command: AnyCommand | ReadInfo, then: Callable[[Answer], None]) -> None:
        try:
            self._session.submit(command, then)
        except zenoh.ZError:
            self._on_closed()
            then(None)
