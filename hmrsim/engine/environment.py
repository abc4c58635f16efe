"""Simpy's environment, extended: alarms, abandoned events, a horizon, and reset."""

from __future__ import annotations

import heapq
import math
from collections import Counter
from collections.abc import Callable, Generator
from typing import Any, Final

import simpy
from simpy.events import NORMAL, URGENT, EventPriority

from hmrsim.engine.internal_errors import BUGS
from hmrsim.engine.sim_time import stamp
from hmrsim.errors import EndlessInstant

_LAST = EventPriority(2)
"""Priority of an event that is processed after all others of its instant."""

_ABANDONED: Final[list[Callable[[simpy.Event], None]]] = []
"""The callbacks of an abandoned timeout, by which it is recognized."""

MOST_AT_ONCE: Final = 5_000_000
"""Maximum events of one instant: large fleets need many thousands when they begin; more would never end."""

_SAMPLED: Final = 100
"""Events of an endless instant that are sampled for the error message."""

_INSTANT: Final = 1e-9
"""Maximum seconds between events of one instant."""

_MAX_ABANDONED: Final = 100
"""Abandoned events that stay scheduled even if they are more than all others."""


class _Clock(simpy.Environment):
    """Simpy's environment, with its time in a slot for fast access."""

    __slots__ = ("_now",)


class Environment(_Clock):
    """The clock and the events of a simulation.

    Use `process_events` rather than simpy's ``run(until=…)``, which leaves a stale event in the schedule.

    Args:
        on_error: Called with an error of a callback, or of a process that no other process waits for, and with the
            process that the error has stopped, if any. Other callbacks still run. By default the error is raised.

    Attributes:
        now: The simulated time, in seconds; read-only.
        horizon: The last instant whose events `process_events` processes.
    """

    # Simpy's property costs a function call, and time is read several times per event.
    now: float = _Clock._now  # type: ignore[misc]  # noqa: SLF001 - the slot's descriptor
    horizon = math.inf
    _scheduled = 0
    """The number of events scheduled so far; it orders events of equal time and priority."""
    _stamped = (-1.0, 0)
    """The latest instant whose stamp was read, and the stamp."""
    _abandoned = 0
    """The number of abandoned events in the schedule."""
    _background = 0
    """The number of scheduled alarms; time does not advance for them."""
    _at_once = 0
    """The number of consecutive events of one instant, counted in whole calls of `process_events`."""

    def __init__(self, on_error: Callable[[BaseException, simpy.Process | None], None] | None = None) -> None:
        super().__init__()
        self._on_error = _raise if on_error is None else on_error

    @property
    def stamp(self) -> int:
        """The stamp of this instant."""
        at, number = self._stamped
        if at != self._now:
            number = stamp(self._now)
            self._stamped = self._now, number
        return number

    @property
    def idle(self) -> bool:
        """Return whether only alarms and abandoned events are scheduled."""
        return len(self._queue) == self._abandoned + self._background

    def alarm(self, delay: float, ring: Callable[[], None]) -> Alarm:
        """Call *ring* after a delay, if time advances that far for other events; `cancel` cancels the alarm.

        An ordinary event would keep an otherwise finished simulation running, for instance until an idle robot's
        battery reaches its next level.
        """
        alarm = Alarm(self, ring)
        self._background += 1
        self.schedule(alarm, NORMAL, delay)
        return alarm

    def alarm_at(self, at: float, ring: Callable[[], None]) -> Alarm:
        """Call *ring* like `alarm`, but at an exact simulated time, which a delay could miss by rounding.

        Raises:
            ValueError: The time is NaN.
        """
        alarm = Alarm(self, ring)
        self.schedule_at(alarm, at)
        self._background += 1
        return alarm

    def cancel(self, alarm: Alarm) -> None:
        """Cancel an alarm; do nothing if it has rung."""
        if alarm.callbacks is not None and alarm.callbacks is not _ABANDONED:
            self._background -= 1
            self.abandon(alarm)

    def advance_clock(self, to: float) -> None:
        """Set the time to *to*; no event may be due before."""
        self._now = to

    def step(self) -> None:
        """Process the next event like simpy's own `step`, but pass errors to `on_error`."""
        self._now, _, _, event = heapq.heappop(self._queue)
        callbacks, event.callbacks = event.callbacks, None  # type: ignore[assignment]  # simpy's mark of a processed one
        for callback in callbacks:
            try:
                callback(event)
            except BUGS as error:
                process, self._active_proc = self._active_proc, None
                self._on_error(error if process is None else _no_event(error), process)
        if not event._ok and not hasattr(event, "_defused"):  # noqa: SLF001 - simpy has no other way to ask
            failure: BaseException = event._value  # noqa: SLF001
            if not isinstance(failure, BUGS):
                raise failure
            self._on_error(failure, event if isinstance(event, simpy.Process) else None)

    def schedule(self, event: simpy.Event, priority: EventPriority = NORMAL, delay: float = 0) -> None:
        """Schedule an event after a delay in simulated seconds.

        Raises:
            ValueError: The delay is NaN, which would put all events out of order.
        """
        if event is self._active_proc and event._ok and not event.callbacks:  # noqa: SLF001 - as simpy does
            # A process has ended, and nothing waits for it.
            event.callbacks = None  # type: ignore[assignment]  # simpy's mark of a processed event
            return
        at = self._now + delay
        if at != at:  # noqa: PLR0124 - NaN; this is done for each event
            raise ValueError("a delay is NaN")
        self._scheduled += 1
        heapq.heappush(self._queue, (at, priority, self._scheduled, event))

    def succeed(self, event: simpy.Event) -> None:
        """Trigger an event at this instant, after all events that are due; run its callbacks directly if none is.

        Call it last in a callback. The direct call avoids the schedule.
        """
        if self._active_proc is not None or event.triggered or (self._queue and self._queue[0][0] <= self._now):
            event.succeed()
            return
        event._ok, event._value = True, None  # noqa: SLF001 - as simpy's own `step` does
        callbacks, event.callbacks = event.callbacks, None  # type: ignore[assignment]
        for callback in callbacks:
            callback(event)

    def kill(self, process: simpy.Process) -> None:
        """End a process without resuming it; its ``finally`` blocks run now."""
        target = process.target
        if target is not None and target.callbacks and process._resume in target.callbacks:  # noqa: SLF001 - as simpy does
            target.callbacks.remove(process._resume)  # noqa: SLF001
        if process.is_alive:
            process.succeed()
        process._generator.close()  # noqa: SLF001

    def process_events(self, most: int, *, idle: bool = True) -> int:
        """Process up to *most* events that are due by the horizon; return their number.

        If *idle* is False, stop once only alarms and abandoned events are left.

        Raises:
            EndlessInstant: More than `MOST_AT_ONCE` events were due at one instant.
        """
        queue, step, began = self._queue, self.step, self._now
        for processed in range(most):
            if queue and queue[0][3].callbacks is _ABANDONED:
                self._clear()
            # Any event may move the horizon closer.
            if not queue or queue[0][0] > self.horizon or (self._background and not idle and self.idle):
                self._at_once = 0
                return processed
            step()
        self._at_once = self._at_once + most if self._now - began < _INSTANT else 0
        if self._at_once > MOST_AT_ONCE:
            raise self._endless()
        return most

    def _endless(self) -> EndlessInstant:
        """Process some more events of this instant; return the error, which names the most frequent waiters."""
        seen = Counter[str]()
        while self._queue and seen.total() < _SAMPLED:
            callbacks = self._queue[0][3].callbacks or ()
            seen.update([_whose(callback) for callback in callbacks] or ["nobody"])
            self.step()
        names = ", ".join(f"{name} ({number} of {seen.total()})" for name, number in seen.most_common(3))
        return EndlessInstant(
            f"time stands still at {self._now:g} s: more than {MOST_AT_ONCE:,} events were due there;"
            f" most of those that follow are of {names}"
        )

    def peek(self) -> float:
        """Return the time of the next event that is not abandoned; infinite if there is none."""
        queue = self._queue
        if queue and queue[0][3].callbacks is _ABANDONED:
            self._clear()
        return queue[0][0] if queue else math.inf

    def abandon(self, event: simpy.Timeout | At | Alarm) -> None:
        """Abandon a timed event that no process waits for: time does not advance for it."""
        event.callbacks = _ABANDONED
        self._abandoned += 1
        # Otherwise events due far in the future would pile up.
        if self._abandoned > _MAX_ABANDONED and 2 * self._abandoned > len(self._queue):
            self._queue[:] = [entry for entry in self._queue if entry[3].callbacks is not _ABANDONED]
            heapq.heapify(self._queue)
            self._abandoned = 0

    def wait(self, woken: simpy.Event, until: float) -> Generator[simpy.Event, Any, None]:
        """Wait for an event, and trigger it at the time *until* if it has not happened by then; infinity for never.

        A simpy condition would leave callbacks on events that may never happen when its process is interrupted.
        """

        def wake(_event: simpy.Event) -> None:
            if not woken.triggered:
                woken.succeed()

        timeout = At(self, until, [wake]) if until < math.inf else None
        try:
            yield woken
        finally:
            if timeout is not None and not timeout.processed:
                self.abandon(timeout)

    def call_soon(self, call: Callable[[], None]) -> None:
        """Call a function at this instant, before all events that are due."""
        self._scheduled += 1
        heapq.heappush(self._queue, (self._now, URGENT, self._scheduled, _Call(self, call)))

    def _clear(self) -> None:
        """Remove abandoned events from the top of the schedule."""
        queue = self._queue
        while queue and queue[0][3].callbacks is _ABANDONED:
            heapq.heappop(queue)
            self._abandoned -= 1

    def take_urgent(self) -> None:
        """Process the starts and interrupts of processes that are due now."""
        while self._queue and self._queue[0][0] <= self._now and self._queue[0][1] == URGENT:
            self.step()

    def schedule_at(self, event: simpy.Event, at: float) -> None:
        """Schedule an event at an exact time, which a delay could miss by rounding.

        Raises:
            ValueError: The time is NaN, which would put all events out of order.
        """
        if at != at:  # noqa: PLR0124 - NaN
            raise ValueError("a time is NaN")
        self._scheduled += 1
        heapq.heappush(self._queue, (at, NORMAL, self._scheduled, event))

    def schedule_last(self, event: simpy.Event, at: float) -> None:
        """Schedule an event at an exact time, after all other events of that instant."""
        self._scheduled += 1
        heapq.heappush(self._queue, (at, _LAST, self._scheduled, event))

    def restart(self) -> None:
        """Reset time to 0 and drop future events; events that are due now become due at 0."""
        self._queue[:] = [(0.0, *rest) for at, *rest in self._queue if at <= self._now]  # type: ignore[misc]
        heapq.heapify(self._queue)
        self._abandoned = sum(event.callbacks is _ABANDONED for *_, event in self._queue)
        self._background = sum(
            isinstance(event, Alarm) and event.callbacks is not _ABANDONED for *_, event in self._queue
        )
        self._now = 0.0


def _whose(callback: Callable[[simpy.Event], None]) -> str:
    """Return the owner of a callback: a process, with the line at which it waits, or a function."""
    owner = getattr(callback, "__self__", None)
    if not isinstance(owner, simpy.Process):
        return str(getattr(callback, "__qualname__", callback))
    generator: Any = owner._generator  # noqa: SLF001 - simpy has no other way to ask
    code, frame = generator.gi_code, generator.gi_frame
    return f"{code.co_qualname} ({code.co_filename}:{frame.f_lineno if frame else code.co_firstlineno})"


def _no_event(error: BaseException) -> BaseException:
    """Return the error of a process that yielded no event, without the wrong source position that simpy adds."""
    text = str(error).rpartition("\n")[2]
    return RuntimeError(text).with_traceback(error.__traceback__) if isinstance(error, RuntimeError) else error


def _raise(error: BaseException, _process: simpy.Process | None) -> None:
    raise error


class At(simpy.Event):
    """An event at an exact time, in simulated seconds."""

    def __init__(self, env: Environment, at: float, callbacks: list[Callable[[simpy.Event], None]]) -> None:
        # Like simpy's timeout, it skips the base class's constructor to save time.
        self.env = env
        self.callbacks = callbacks
        self._ok, self._value = True, None
        env.schedule_at(self, at)


class _Call(simpy.Event):
    """An event that calls a function."""

    def __init__(self, env: Environment, call: Callable[[], None]) -> None:
        # Skips the base class's constructor, like `At`.
        self.env = env
        self.callbacks = [lambda _event: call()]
        self._ok, self._value = True, None


class Tick(simpy.Event):
    """An event at an exact time, after all other events of that instant."""

    def __init__(self, env: Environment, at: float) -> None:
        super().__init__(env)
        self._ok, self._value = True, None
        env.schedule_last(self, at)


class Alarm(simpy.Event):
    """An event at a time that does not keep the simulation running until then."""

    def __init__(self, env: Environment, ring: Callable[[], None]) -> None:
        super().__init__(env)
        self._ok, self._value = True, None

        def on_due(_event: simpy.Event) -> None:
            env._background -= 1  # noqa: SLF001 - counted in `Environment.alarm`
            ring()

        self.callbacks = [on_due]
