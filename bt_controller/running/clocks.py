"""The clocks of a runner, which wait for its mailbox between ticks, or advance a simulator in lockstep."""

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
    from hmrsim_zenoh.client.lockstep import Kind, Lockstep

_CHECK_SECONDS: Final = 0.5
"""Wall seconds after which an idle runner checks its connection."""

_CANCEL_SECONDS: Final = 0.5
"""Wall seconds that the advance that cancels the goals may take; it depends on the other participants."""

_FIRST_CLOCK_SECONDS: Final = 1.0
"""Wall seconds to wait for a simulator's first clock message."""

_STALE_CLOCK_SECONDS: Final = 0.05
"""Wall seconds in which clock messages may arrive that are older than the time queried first."""


class Clock(Protocol):
    """Simulated time, and the wait for the events that wake a runner."""

    @property
    def now(self) -> float | None:
        """Simulated seconds; None while unknown."""

    @property
    def elapsed(self) -> float | None:
        """Simulated seconds that never go back: a reset does not set them to 0."""

    def wait(self, until: float | None) -> frozenset[str]:
        """Wait for the mailbox and return its reasons; none if the wait ended at the time *until*, or earlier.

        Args:
            until: The value of `elapsed` to wait for; None for no limit.

        Raises:
            SimulatorGone, SimulatorNotFound: The simulator sends no further events.
            Idle, Dropped: Lockstep can't continue.
        """

    def settle(self, done: Callable[[], bool], seconds: float) -> None:
        """Wait until canceled goals have ended, `STOP` arrives, or some wall seconds have passed."""

    def close(self) -> None:
        """Stop following time."""


def clock_for(client: Client, mailbox: Mailbox, *, feedback: bool, grace: float) -> Clock:
    """Return the clock that fits a client's connection: lockstep, or real time.

    Args:
        client: The connection to the simulator.
        mailbox: The mailbox for events of goals and for signals.
        feedback: Whether to request the feedback of goals in lockstep, so that trees know it at each tick.
        grace: Wall seconds for which the simulator may be unreachable, except in lockstep.

    Raises:
        RequestError: The simulator refuses this participant.
        SimulatorNotFound, SimulatorGone: No simulator answers.
    """
    lockstep = client.lockstep
    if lockstep is None:
        return RealtimeClock(client, mailbox, grace)
    return LockstepClock(client, lockstep, mailbox, feedback=feedback, grace=grace)


class RealtimeClock:
    """Simulated time that advances by itself.

    Args:
        mailbox: The mailbox for events of goals and of the clock, and for signals.
        grace: Wall seconds for which the simulator may be unreachable.
        set_back: The seconds by which earlier resets set time back.
    """

    def __init__(self, client: Client, mailbox: Mailbox, grace: float, *, set_back: float = 0.0) -> None:
        self._client = client
        self._mailbox = mailbox
        self._grace = grace
        self._absent_since: float | None = None
        self._received_first = threading.Event()
        self._last = 0.0
        self._set_back = set_back
        self._elapsed: float | None = None
        # The wall time from which an older clock message means a reset.
        self._stale_until: float | None = None
        self._until: float | None = None
        self._clock = SimClock(client, self._on_time)
        # Timers that begin at the first tick need the time of it.
        self._received_first.wait(_FIRST_CLOCK_SECONDS)

    @property
    def now(self) -> float | None:
        """Simulated seconds; None before the first clock message."""
        return self._clock.now

    @property
    def elapsed(self) -> float | None:
        """Simulated seconds that never go back; None before the first clock message."""
        return self._elapsed

    def wait(self, until: float | None) -> frozenset[str]:
        """Wait for the mailbox and return its reasons; none after a while, to check the connection."""
        self._until = until
        if until is not None and self._elapsed is not None and self._elapsed >= until:
            return self._mailbox.wait(0.0)
        reasons = self._mailbox.wait(_CHECK_SECONDS)
        if self._is_gone():
            raise SimulatorGone("the simulator is gone")
        return reasons

    def settle(self, done: Callable[[], bool], seconds: float) -> None:
        """Wait until canceled goals have ended: closing the session earlier could lose a cancel request."""
        until = time.monotonic() + seconds
        while not done():
            remaining = until - time.monotonic()
            if remaining <= 0 or STOP in self._mailbox.wait(remaining):
                return

    def close(self) -> None:
        """Unsubscribe from the clock messages."""
        self._clock.close()

    def _on_time(self, now: float) -> None:
        if self._stale_until is None:
            self._stale_until = time.monotonic() + _STALE_CLOCK_SECONDS
        if now < self._last:
            if time.monotonic() < self._stale_until:
                return
            self._set_back += self._last - now
            self._mailbox.put(RESET)
        self._last = now
        self._elapsed = now + self._set_back
        self._received_first.set()
        until = self._until
        if until is not None and self._elapsed >= until:
            self._until = None
            self._mailbox.put(CLOCK)

    def _is_gone(self) -> bool:
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
        self._last = lockstep.now
        self._set_back = 0.0
        # Follows time after the simulator has left lockstep.
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
        return max(self._lockstep.now, self._last) + self._set_back

    def wait(self, until: float | None) -> frozenset[str]:
        """Send the trees' requests, advance, and return the reasons to tick."""
        if self._successor is None and self._lockstep.over:
            self._successor = RealtimeClock(self._client, self._mailbox, self._grace, set_back=self._set_back)
        if self._successor is not None:
            return self._successor.wait(until)
        self._detect_reset()
        if reasons := self._mailbox.wait(0.0):
            return reasons
        limit = None if until is None else until - self._set_back
        self._lockstep.advance(until=limit, report=self._report, timeout=_CHECK_SECONDS)
        self._detect_reset()
        return self._mailbox.wait(0.0)

    def _detect_reset(self) -> None:
        """Report a reset to the mailbox if time has gone back."""
        before, self._last = self._last, self._lockstep.now
        if self._last < before:
            self._set_back += before - self._last
            self._mailbox.put(RESET)

    def settle(self, done: Callable[[], bool], seconds: float) -> None:
        """Send the cancel requests without advancing time."""
        if self._successor is not None:
            self._successor.settle(done, seconds)
            return
        until = time.monotonic() + min(seconds, _CANCEL_SECONDS)
        with suppress(HmrsimError):
            # A pending advance has to be granted first, which depends on the other participants.
            for _ in range(2):
                if done():
                    return
                self._lockstep.advance(until=self.now, timeout=until - time.monotonic())

    def close(self) -> None:
        """Leave lockstep, so that the other participants continue."""
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

    Any thread may put a reason, even a signal handler that interrupts the waiting thread.
    """

    def __init__(self) -> None:
        # Not a threading.Condition: it would lose a signal that arrives between its test and its wait.
        self._queue: SimpleQueue[str] = SimpleQueue()

    def put(self, reason: str) -> None:
        """Wake the waiting thread; return at once."""
        self._queue.put(reason)

    def wait(self, timeout: float) -> frozenset[str]:
        """Return the reasons, as soon as there is one; none after *timeout* wall seconds."""
        if timeout <= 0.0 and self._queue.empty():
            return frozenset()
        try:
            reasons = {self._queue.get(timeout=timeout)}
        except Empty:
            return frozenset()
        while not self._queue.empty():
            reasons.add(self._queue.get())
        return frozenset(reasons)
