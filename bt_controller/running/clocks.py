"""A runner's clock until the next tick: it waits for events in its mailbox, or it advances a simulator in lockstep."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import suppress
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Final, Protocol

from hmrsim.errors import HmrsimError
from hmrsim_zenoh.client.subscription import SimClock
from hmrsim_zenoh.errors import SimulatorGone

if TYPE_CHECKING:
    from hmrsim_zenoh.client.client import Client
    from hmrsim_zenoh.client.lockstep import Lockstep
    from hmrsim_zenoh.client.participant import Kind

_LOOK_AROUND: Final = 0.5
"""Wall seconds after which an idle runner checks its connection."""

_LAST_WORDS: Final = 0.5
"""Wall seconds that the other participants have to grant the advance that cancels the goals."""

_FIRST_TIME: Final = 1.0
"""Wall seconds within which a simulator's first clock message arrives."""


_OVERTAKEN: Final = 0.05
"""Wall seconds in which clock messages may arrive that are older than the first, queried time."""


class Clock(Protocol):
    """Simulated time, and the events that wake a runner."""

    @property
    def now(self) -> float | None:
        """Simulated seconds; None while unknown."""

    @property
    def elapsed(self) -> float | None:
        """Simulated seconds that never go back: those before a reset count."""

    def wait(self, until: float | None) -> frozenset[str]:
        """Wait for the mailbox and return its reasons; none at the time *until*, or earlier.

        Args:
            until: The value of `elapsed` to wait for; None for no limit.

        Raises:
            SimulatorGone: The simulator sends no further events.
            Idle, Dropped, SimulatorNotFound: The same, in lockstep.
        """

    def settle(self, done: Callable[[], bool], seconds: float) -> None:
        """Wait for the end of goals that were canceled; at most some wall seconds, or until `STOP`."""

    def close(self) -> None:
        """Stop following time."""


def clock_for(client: Client, mailbox: Mailbox, *, feedback: bool, grace: float) -> Clock:
    """Return the clock that a client has.

    Args:
        client: The connection to the simulator.
        mailbox: Where goals and signals say that something has happened.
        feedback: Whether trees are to know their goals' feedback whenever they are ticked, also in lockstep.
        grace: Wall seconds for which a simulator whose time moves by itself may be out of reach.

    Raises:
        RequestError: The simulator refuses this participant.
        SimulatorNotFound, SimulatorGone: No simulator answers.
    """
    lockstep = client.lockstep
    if lockstep is None:
        return RealtimeClock(client, mailbox, grace)
    return LockstepClock(client, lockstep, mailbox, feedback=feedback, grace=grace)


class RealtimeClock:
    """Simulated time that moves by itself.

    Args:
        mailbox: Where goals, signals and the clock say that something has happened.
        grace: Wall seconds for which the simulator may be out of reach.
        set_back: By how many seconds it was set back already.
    """

    def __init__(self, client: Client, mailbox: Mailbox, grace: float, *, set_back: float = 0.0) -> None:
        self._client = client
        self._mailbox = mailbox
        self._grace = grace
        self._absent_since: float | None = None
        self._heard = threading.Event()
        self._before = 0.0
        self._set_back = set_back
        self._elapsed: float | None = None
        self._believes_from = 0.0
        self._until: float | None = None
        self._clock = SimClock(client, self._on_time)
        # Timers that begin at the first tick need to know when that is.
        self._heard.wait(_FIRST_TIME)

    @property
    def now(self) -> float | None:
        """Simulated seconds; None until a clock message was received."""
        return self._clock.now

    @property
    def elapsed(self) -> float | None:
        """Simulated seconds that never go back; None until a clock message was received."""
        return self._elapsed

    def wait(self, until: float | None) -> frozenset[str]:
        """Wait for the mailbox and return its reasons; none after a while, to check the connection."""
        self._until = until
        if until is not None and self._elapsed is not None and self._elapsed >= until:
            return self._mailbox.wait(0.0)
        woken = self._mailbox.wait(_LOOK_AROUND)
        if self._gone():
            raise SimulatorGone("the simulator is gone")
        return woken

    def settle(self, done: Callable[[], bool], seconds: float) -> None:
        """Wait until the goals have ended: a session closed too soon could lose a cancel on its way."""
        until = time.monotonic() + seconds
        while not done():
            left = until - time.monotonic()
            if left <= 0 or STOP in self._mailbox.wait(left):
                return

    def close(self) -> None:
        """Unsubscribe from the clock messages."""
        self._clock.close()

    def _on_time(self, now: float) -> None:
        if now < self._before:
            if time.monotonic() < self._believes_from:
                return
            self._set_back += self._before - now
            self._mailbox.put(RESET)
        self._before = now
        self._believes_from = self._believes_from or time.monotonic() + _OVERTAKEN
        self._elapsed = now + self._set_back
        self._heard.set()
        until = self._until
        if until is not None and self._elapsed >= until:
            self._until = None
            self._mailbox.put(CLOCK)

    def _gone(self) -> bool:
        """Return whether the simulator has been unreachable for longer than a router takes to restart."""
        if self._client.alive:
            self._absent_since = None
            return False
        now = time.monotonic()
        if self._absent_since is None:
            self._absent_since = now
        return now - self._absent_since >= self._grace


class LockstepClock:
    """Simulated time in lockstep, which the runner advances."""

    def __init__(self, client: Client, lockstep: Lockstep, mailbox: Mailbox, *, feedback: bool, grace: float) -> None:
        self._client = client
        self._lockstep = lockstep
        self._mailbox = mailbox
        self._report: tuple[Kind, ...] = ("feedback",) if feedback else ()
        self._grace = grace
        self._before = lockstep.now
        self._set_back = 0.0
        self._successor: RealtimeClock | None = None

    @property
    def now(self) -> float | None:
        """Simulated seconds since the last reset."""
        return self._lockstep.now if self._successor is None else self._successor.now

    @property
    def elapsed(self) -> float | None:
        """Simulated seconds that never go back."""
        if self._successor is not None:
            return self._successor.elapsed
        # A tree's own request may have reset the simulation since the last grant.
        return max(self._lockstep.now, self._before) + self._set_back

    def wait(self, until: float | None) -> frozenset[str]:
        """Send the trees' requests, advance, and return the reasons to tick."""
        if self._successor is None and self._lockstep.over:
            self._successor = RealtimeClock(self._client, self._mailbox, self._grace, set_back=self._set_back)
        if self._successor is not None:
            return self._successor.wait(until)
        self._look_back()
        if woken := self._mailbox.wait(0.0):
            return woken
        limit = None if until is None else until - self._set_back
        self._lockstep.advance(until=limit, report=self._report, timeout=_LOOK_AROUND)
        self._look_back()
        return self._mailbox.wait(0.0)

    def _look_back(self) -> None:
        """Request a reset if time has gone back."""
        before, self._before = self._before, self._lockstep.now
        if self._before < before:
            self._set_back += before - self._before
            self._mailbox.put(RESET)

    def settle(self, done: Callable[[], bool], seconds: float) -> None:
        """Send the cancel requests without advancing time."""
        if self._successor is not None:
            self._successor.settle(done, seconds)
            return
        until = time.monotonic() + min(seconds, _LAST_WORDS)
        with suppress(HmrsimError):
            # A pending advance has to be granted first, which depends on the other participants.
            for _ in range(2):
                if not done():
                    self._lockstep.advance(until=self.now, timeout=until - time.monotonic())

    def close(self) -> None:
        """Leave the lockstep, so that the others go on."""
        self._lockstep.close()
        if self._successor is not None:
            self._successor.close()


CLOCK: Final = "/clock"
"""The awaited time has come."""
RESET: Final = "/reset"
"""Time went back."""
STOP: Final = "/stop"
"""The user requests the end."""


class Mailbox:
    """Collects the reasons to wake: a robot's name, `CLOCK`, `RESET` or `STOP`.

    Any thread may put, and so may a signal handler that interrupts the thread which waits.
    """

    def __init__(self) -> None:
        # A condition would do for threads; but a signal between its test and its wait would be lost.
        self._queue: SimpleQueue[str] = SimpleQueue()

    def put(self, reason: str) -> None:
        """Wake the waiting thread; returns at once."""
        self._queue.put(reason)

    def wait(self, timeout: float) -> frozenset[str]:
        """Return the reasons that came, as soon as there is one; none after *timeout* wall seconds."""
        if timeout <= 0.0 and self._queue.empty():
            return frozenset()
        try:
            reasons = {self._queue.get(timeout=timeout)}
        except Empty:
            return frozenset()
        while not self._queue.empty():
            reasons.add(self._queue.get())
        return frozenset(reasons)
