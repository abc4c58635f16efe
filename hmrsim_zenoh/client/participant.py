"""A participant in a simulator's lockstep: the requests ``join``, ``advance`` and ``leave``.

Time moves only when every participant has requested an advance. If a reply is lost, the same request is
sent again and gets the same answer.
"""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final, Literal

from hmrsim.protocol.commands import Advance
from hmrsim.protocol.outputs import Granted
from hmrsim.protocol.time import Join, Joined, Leave, ReadTime, TimeState
from hmrsim_zenoh.errors import Dropped, NameTaken, RequestError

if TYPE_CHECKING:
    from hmrsim_zenoh.client.connection import Call
    from hmrsim_zenoh.client.link import Link

Kind = Literal["result", "feedback", "status"]
"""Kinds of events that can wake a participant or be reported to it."""

_NAME: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")

# Zenoh's default query timeout is 10 s; other participants may take longer, and a pause may last.
_FOR_EVER: Final = 1e6
_ONE_TRY: Final = 3.0
_LAST_WORDS: Final = 1.0
_PAUSE: Final = 0.1
_LOCKSTEP: Final = "lockstep"


Kinds = frozenset[Kind]
NO_KINDS: Final[Kinds] = frozenset()


class Participant:
    """A participant for which a simulator's time waits. For one thread at a time, except for `fail`.

    Attributes:
        epoch: The epoch of the next advance.
        now: Simulated seconds of the last grant.
        request: The pending advance; None if there is none.
    """

    def __init__(self, link: Link, name: str) -> None:
        self.name = name
        self.epoch = 0
        self.now = 0.0
        self._link = link
        self._connection = link.connection
        self._withdraw: Callable[[], None] | None = None
        self.request: Advance | None = None
        self._call: Call | None = None
        self._resynchronized = False
        self._failure: Exception | None = None

    def join(self) -> int:
        """Join, and return how many goals were sent under this name before.

        Raises:
            NameTaken: Another participant has this name.
            RequestError: The simulator refuses this participant, for the reason in the text.
            SimulatorNotFound, SimulatorGone, ClientClosed: There is no simulator to join.
        """
        self._link.enter(self)
        try:
            self._withdraw = self._connection.announce(self.name)
            joined = self._join()
        except BaseException:
            self.close()
            raise
        self.epoch, self.now = joined.epoch, joined.now
        return joined.goals

    def ask(
        self,
        until: float = math.inf,
        wake: Kinds = NO_KINDS,
        report: Kinds = NO_KINDS,
        commands: tuple[Any, ...] = (),
    ) -> None:
        """Prepare an advance, which `take` sends.

        Args:
            until: Simulated seconds; infinite for as far as anything is scheduled.
            wake: The kinds of events that end the advance.
            report: Further kinds of events to report; of feedback only the latest of each goal.
            commands: The commands to apply first, in this order.
        """
        self._resynchronized = False
        self.request, self._call = Advance(self.name, self.epoch, until, wake, report, commands), None

    def take(self, timeout: float = math.inf) -> Granted | None:
        """Wait for the answer; None if it does not come within *timeout* wall seconds: the caller may wait again.

        An interrupt loses nothing: this returns the same answer until the caller has called `accept` with it.

        Raises:
            Dropped: The simulator goes on without this participant.
            RequestError: The simulator can't read the request and applied none of it.
            SimulatorNotFound, SimulatorGone, ClientClosed: There will be no answer.
        """
        limit = time.monotonic() + timeout
        while (request := self.request) is not None:
            call = self._call
            if call is None:
                call = self._call = self._connection.call(request, timeout=_FOR_EVER)
            if (call.answer is None or self._failure is not None) and not self._answered(
                call, limit - time.monotonic()
            ):
                break
            answer = call.answer
            if isinstance(answer, Granted):
                return answer
            if isinstance(answer, RequestError):
                if (grant := self._ended(request, answer)) is not None:
                    return grant
                self._resynchronized = True
            self._call = None
        return None

    def accept(self, grant: Granted) -> None:
        """Go on from where a grant leaves off; the next advance may be requested."""
        self.epoch, self.now = grant.epoch, grant.now
        self.request = None

    def look_at_time(self) -> None:
        """Ask for the time, and take it over if it has gone back."""
        state = self._state()
        if state is not None and state.clock == _LOCKSTEP and state.now < self.now:
            self.epoch, self.now = state.epoch, state.now

    def leave(self) -> None:
        """Leave, and report that to the simulator."""
        if self._withdraw is not None:
            self._connection.call(Leave(self.name), timeout=_LAST_WORDS).wait(_LAST_WORDS)
        self.close()

    def close(self) -> None:
        """Leave without a request to the simulator."""
        self._link.leave(self)
        withdraw, self._withdraw = self._withdraw, None
        if withdraw is not None and not self._link.closed:
            withdraw()

    def fail(self, error: Exception) -> None:
        """Fail the pending request; from any thread."""
        self._failure = error
        if (call := self._call) is not None:
            call.give_up()

    def _join(self) -> Joined:
        command = Join(self.name, token=self._connection.token())
        while True:
            self._call = call = self._connection.call(command, timeout=_ONE_TRY)
            self._answered(call, math.inf)
            match call.answer:
                case Joined() as joined:
                    return joined
                case RequestError() as error:
                    raise NameTaken(str(error), error.details) if _field(error) == "name" else error

    def _answered(self, call: Call, timeout: float) -> bool:
        """Wait for the answer; an answer of None was lost, and the request may be repeated."""
        if self._failure is not None:
            raise self._failure
        if not call.wait(timeout):
            return False
        if self._failure is not None:
            raise self._failure
        if call.answer is None:
            if absence := self._link.absence():
                raise absence
            if not self._link.is_local_and_alive:
                time.sleep(_PAUSE)
        return True

    def _ended(self, request: Advance, error: RequestError) -> Granted | None:
        """Return the last grant if time moves by itself now; None to repeat the request after a reset.

        Raises:
            Dropped: The simulator goes on without this participant.
            RequestError: The error has another cause.
        """
        field = _field(error)
        state = self._state()
        if state is None:
            self.request = None
            raise error
        if state.clock != _LOCKSTEP:
            return Granted(state.epoch, state.now, "end")
        if field == "epoch" and not self._resynchronized:
            # The simulation was reset before this request.
            if state.now < self.now:
                # The request was meant for the old time; an advance without commands shows the new one first.
                request = request._replace(until=state.now, commands=())
            self.request = request._replace(epoch=state.epoch)
            self.epoch, self.now = state.epoch, state.now
            return None
        self.request = None
        raise Dropped(str(error)) if field == "participant" else error

    def _state(self) -> TimeState | None:
        call = self._connection.call(ReadTime(), timeout=_ONE_TRY)
        call.wait(_ONE_TRY)
        return call.answer if isinstance(call.answer, TimeState) else None


def check_name(name: str) -> None:
    """Check a participant's name.

    Raises:
        ValueError: The name is invalid.
    """
    if not _NAME.fullmatch(name):
        raise ValueError(
            f"{name!r} is not a valid participant name; expected letters, digits and underscores, no digit first"
        )


def _field(error: RequestError) -> object:
    """Return the invalid field of a request; None if the error does not name one."""
    return error.details[0].get("field") if error.details else None
