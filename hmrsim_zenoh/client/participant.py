"""A participant in a simulator's lockstep: the requests ``join``, ``advance`` and ``leave``.

Time moves only when every participant has requested an advance. If a reply is lost, the same request is
sent again and gets the same answer.
"""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
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


@dataclass(frozen=True)
class Wish:
    """The content of an advance.

    Attributes:
        until: Simulated seconds; None for as far as anything is scheduled.
        wake: The kinds of events that end the advance.
        report: Further kinds of events to report; of feedback only the latest of each goal.
        commands: The commands to apply first, in this order.
    """

    until: float | None = None
    wake: frozenset[Kind] = frozenset()
    report: frozenset[Kind] = frozenset()
    commands: tuple[Any, ...] = ()


class Participant:
    """A participant for which a simulator's time waits. For one thread at a time, except for `fail`.

    Attributes:
        now: Simulated seconds of the last grant.
    """

    def __init__(self, link: Link, name: str) -> None:
        self.name = name
        self.epoch = 0
        self.now = 0.0
        self._link = link
        self._connection = link.connection
        self._withdraw: Callable[[], None] | None = None
        self._wish: Wish | None = None
        self._call: Call | None = None
        self._resynchronised = False
        self._failure: Exception | None = None

    @property
    def asking(self) -> bool:
        """Whether an advance is pending."""
        return self._wish is not None

    def join(self) -> int:
        """Join, and return how many goals were sent under this name before.

        Raises:
            NameTaken: Another participant has this name.
            RequestError: The simulator refuses this participant; the text says why.
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

    def ask(self, wish: Wish) -> None:
        """Request an advance; `take` sends it and returns the answer."""
        self._resynchronised = False
        self._wish, self._call = wish, None

    def take(self, timeout: float = math.inf) -> Granted | None:
        """Wait for the answer; None if it does not come within *timeout* wall seconds: the caller may wait again.

        An interrupt loses nothing: this returns the same answer until the caller has called `accept` with it.

        Raises:
            Dropped: The simulator goes on without this participant.
            RequestError: The simulator can't read the request and applied none of it.
            SimulatorNotFound, SimulatorGone, ClientClosed: There will be no answer.
        """
        limit = time.monotonic() + timeout
        if self._call is None:
            self._call = self._advance()
        while self._answered(self._call, limit - time.monotonic()):
            answer = self._call.answer
            if isinstance(answer, Granted):
                return answer
            if isinstance(answer, RequestError):
                if (grant := self._ended(answer)) is not None:
                    return grant
                self._resynchronised = True
            self._call = self._advance()
        return None

    def accept(self, grant: Granted) -> None:
        """Go on from where a grant leaves off; the next advance may be requested."""
        self.epoch, self.now = grant.epoch, grant.now
        self._wish = None

    def look_at_time(self) -> None:
        """Ask for the time, and take it over if it has gone back."""
        state = self._state()
        if state is not None and state.clock == _LOCKSTEP and state.now < self.now:
            self.epoch, self.now = state.epoch, state.now

    def leave(self) -> None:
        """Leave, and tell the simulator if it is there."""
        if self._withdraw is not None:
            self._connection.call(Leave(self.name), timeout=_LAST_WORDS).wait(_LAST_WORDS)
        self.close()

    def close(self) -> None:
        """Leave without telling the simulator."""
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

    def _advance(self) -> Call:
        wish = self._wish or Wish()
        until = math.inf if wish.until is None else wish.until
        command = Advance(self.name, self.epoch, until, wish.wake, wish.report, wish.commands)
        return self._connection.call(command, timeout=_FOR_EVER)

    def _answered(self, call: Call, timeout: float) -> bool:
        """Wait for the answer; an answer of None was lost, and the request may be repeated."""
        self._check()
        if not call.wait(timeout):
            return False
        self._check()
        if call.answer is None:
            if absence := self._link.absence():
                raise absence
            if not self._link.is_local_and_alive:
                time.sleep(_PAUSE)
        return True

    def _check(self) -> None:
        if self._failure is not None:
            raise self._failure

    def _ended(self, error: RequestError) -> Granted | None:
        """Return the last grant if time moves by itself now; None to repeat the request after a reset.

        Raises:
            Dropped: The simulator goes on without this participant.
            RequestError: The error has another cause.
        """
        field = _field(error)
        state = self._state()
        if state is None:
            self._wish = None
            raise error
        if state.clock != _LOCKSTEP:
            return Granted(state.epoch, state.now, "end")
        if field == "epoch" and not self._resynchronised:
            # The simulation was reset before this request.
            if self._wish is not None and state.now < self.now:
                # The request was meant for the old time; an advance without commands shows the new one first.
                self._wish = replace(self._wish, until=state.now, commands=())
            self.epoch, self.now = state.epoch, state.now
            return None
        self._wish = None
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
            f"{name!r} is no participant's name; letters, digits and underscores are expected, no digit first"
        )


def _field(error: RequestError) -> object:
    """Return the invalid field of a request; None if the error does not name one."""
    return error.details[0].get("field") if error.details else None
