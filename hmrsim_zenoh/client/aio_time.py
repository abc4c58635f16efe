"""Simulated time for the tasks of an event loop.

Where time moves by itself, callbacks of the client end the waits. In lockstep a thread advances time, but only while
every task of the loop waits: tasks finish their work at an instant before time advances, so that each run is the same.
The loop becomes an `OrderedLoop`, whose timers use simulated time.
"""

from __future__ import annotations

import asyncio
import itertools
import math
import threading
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from functools import partial
from operator import itemgetter
from typing import TYPE_CHECKING, Any, Final, TypeVar

from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim_zenoh.client.ordered_loop import OrderedLoop
from hmrsim_zenoh.errors import ClientClosed, SimulatorGone, SimulatorNotFound

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Iterator, Mapping, Sequence

    from hmrsim_zenoh.client.client import Client
    from hmrsim_zenoh.client.connection import Condition
    from hmrsim_zenoh.client.lockstep import Lockstep
    from hmrsim_zenoh.client.subscription import SimClock, Subscription
    from hmrsim_zenoh.errors import RequestError

_LOOK_AROUND: Final = 0.5
"""Wall seconds between two checks for the simulator, where time moves by itself."""
_PASSES: Final = 100
"""Passes of an event loop that can't be ordered, before time advances."""


T = TypeVar("T")


class Waiting:
    """An awaitable that any thread can end by `happen` or `fail`."""

    def __init__(self, time: AsyncTime, until: float = math.inf) -> None:
        self.until = until
        self._time = time
        self._future: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._alarm: SimClock | None = None

    def __await__(self) -> Generator[Any, None, None]:
        """Wait for `happen` or `fail`."""
        self._time.add(self)
        try:
            yield from self._future
        finally:
            self._time.remove(self)
            if self._alarm is not None:
                self._alarm.close()

    def set_alarm(self, client: Client, seconds: float) -> None:
        """End the wait after some simulated seconds, where time moves by itself."""
        self._alarm = client.alarm(seconds, self.happen)

    def happen(self) -> None:
        """End the wait from any thread."""
        self._time.woken = True
        self._time.post(self.finish)

    def fail(self, error: BaseException) -> None:
        """Fail the wait with an error."""
        self._time.woken = True
        self._time.post(partial(self.finish, error))

    def finish(self, error: BaseException | None = None) -> None:
        """End the wait, in the loop's thread."""
        if self._future.done():
            return
        if error is None:
            self._future.set_result(None)
        else:
            self._future.set_exception(error)


class AsyncTime:
    """The time of a client's tasks.

    Where time moves by itself and the simulator goes while no task waits for it, the task that made this object is
    canceled, unless a call has failed before: tasks that wait for each other would wait forever. A call in progress
    reports it itself.

    Attributes:
        woken: Whether a wait has ended, so that time stands still.
        lost: The error for which the task was canceled.
        loop_time: Simulated seconds, as the loop's timers have them: they change only while all tasks wait.
    """

    def __init__(self, client: Client, lockstep: Lockstep | None) -> None:
        self.woken = False
        self.lost: SimulatorGone | None = None
        self._client = client
        self._lockstep = lockstep
        self._loop = asyncio.get_running_loop()
        self._task = asyncio.current_task()
        self._has_failed = False
        self._thread = ThreadPoolExecutor(1, "hmrsim-time")
        self._waits: list[Waiting] = []
        self._passes = 0
        self._looking = False
        self._driving = False
        self._holds = 0
        self._asked: list[tuple[Callable[[], Any], asyncio.Future[Any]]] = []
        self._driver: int | None = None
        self._posted: list[tuple[int, Callable[[], object]]] = []
        self._posting = threading.Lock()
        self._subscriptions: list[Subscription] = []
        self._ranks = itertools.count(1)
        self._fatal: BaseException | None = None
        self._ended: Exception | None = None
        self._looks_around = False
        self._ordered = OrderedLoop.of(self._loop) if lockstep is not None else None
        self.loop_time = 0.0 if lockstep is None else lockstep.now
        if self._ordered is not None:
            self._ordered.enter(self)
        if lockstep is None:
            self._look_around_later()

    def next_rank(self) -> int:
        """Return a rank for what one listener posts."""
        return next(self._ranks)

    def post(self, call: Callable[[], object], rank: int = 0) -> None:
        """Call a function in the loop's thread; from any thread.

        The callbacks of an advance run together, when it is over: no task runs while some of them are missing.

        Args:
            call: The function.
            rank: Callbacks with a smaller rank come first: threads of subscriptions race.
        """
        with self._posting:
            if self._driving and (rank or threading.get_ident() == self._driver):
                self._posted.append((rank, call))
                return
        # A program that ends with an error closes its loop before the goals of its tasks have ended.
        with suppress(RuntimeError):
            self._loop.call_soon_threadsafe(call)

    def has_come(self, stamp: Mapping[str, int]) -> bool:
        """Return whether it is a time, or later; in lockstep by what has been granted."""
        if self._lockstep is None or self._lockstep.over:
            return True
        return round(self._lockstep.now * NANOSECONDS) >= stamp["sec"] * NANOSECONDS + stamp["nanosec"]

    def stop_if_late(self, waits: Sequence[Waiting], stamp: Mapping[str, int]) -> None:
        """Stop time for what some wait for, if it has come too late for that; from any thread."""
        if waits and self.has_come(stamp):
            self.woken = True

    @property
    def stops(self) -> bool:
        """Return whether time stops for conditions, as in lockstep."""
        return self._lockstep is not None and not self._lockstep.over

    def wait(self) -> Waiting:
        """Return an awaitable that ends when `Waiting.happen` is called."""
        return Waiting(self)

    async def now(self) -> float:
        """Return simulated seconds; in lockstep at once, so that no time passes."""
        if self._lockstep is not None and not self._lockstep.over:
            return self._lockstep.now
        return await self.ask(lambda: self._client.now)

    async def ask(self, call: Callable[[], T]) -> T:
        """Return what a call returns that waits for the simulator's answer; no time passes in lockstep.

        An ordered loop makes such calls when all tasks wait, one after the other, and then ends all of them in this
        order: over a network, the answers arrive in any.
        """
        if self._ordered is None or self._driving:
            with self.held():
                try:
                    return await asyncio.to_thread(call)
                except (SimulatorNotFound, SimulatorGone):
                    self._has_failed = True
                    raise
        answer: asyncio.Future[T] = self._ordered.create_future()
        self._asked.append((call, answer))
        return await answer

    def _answer(self) -> None:
        """Make the calls that tasks have asked for, in the thread that also advances time."""
        asked = [each for each in self._asked if not each[1].done()]
        self._asked.clear()
        self._holds += 1

        def end(done: asyncio.Future[list[tuple[Any, BaseException | None]]]) -> None:
            self._holds -= 1
            for (_, answer), (result, error) in zip(asked, done.result(), strict=True):
                if not answer.done():
                    answer.set_result(result) if error is None else answer.set_exception(error)

        calls = [call for call, _ in asked]
        self._loop.run_in_executor(self._thread, _results_of, calls).add_done_callback(end)

    async def sleep(self, seconds: float) -> None:
        """Sleep for a number of simulated seconds.

        Raises:
            ValueError: The time is negative, infinite or not a number.
            SimulationEnded, SimulatorGone, Dropped: Time no longer advances.
        """
        if not 0 <= seconds < math.inf:
            raise ValueError(f"can't sleep for {seconds} s; expected a number of seconds of at least 0")
        if self._ended is not None:
            raise self._ended
        if self._lockstep is not None and not self._lockstep.over:
            await Waiting(self, self._lockstep.now + seconds)
            return
        wait = self.wait()
        wait.set_alarm(self._client, seconds)
        await wait

    def add(self, wait: Waiting) -> None:
        """Add a wait that a task has begun."""
        self._waits.append(wait)
        if self._ended is not None:
            wait.finish(self._ended)
        elif self._lockstep is not None:
            self._look_later()

    def remove(self, wait: Waiting) -> None:
        """Remove a wait that has ended."""
        self._waits.remove(wait)

    @contextmanager
    def watching(self, conditions: Sequence[Condition], wait: Waiting) -> Iterator[None]:
        """Stop time as soon as one of the conditions is met, and end *wait* then."""
        lockstep = self._lockstep

        def then(error: RequestError | None) -> None:
            if lockstep is not None and lockstep.ended is not None:
                wait.fail(lockstep.ended)
            elif error is None or lockstep is None or lockstep.over:
                wait.happen()
            else:
                wait.fail(error)

        takes_back = [lockstep.watch(condition, then) for condition in conditions] if lockstep else []
        try:
            yield
        finally:
            for take_back in takes_back:
                take_back()

    @contextmanager
    def listening(self, subscription: Subscription) -> Iterator[None]:
        """Hold all tasks after an advance until a subscription has delivered its samples."""
        self._subscriptions.append(subscription)
        try:
            yield
        finally:
            self._subscriptions.remove(subscription)

    @contextmanager
    def held(self) -> Iterator[None]:
        """Hold time in lockstep even if every task waits, as a message is on its way over the network."""
        self._holds += 1
        try:
            yield
        finally:
            self._holds -= 1
            if self._waits:
                self._look_later()

    def close(self) -> None:
        """End the thread after its current call, and abandon all waits."""
        self.woken = True
        self._leave_order()
        self._ended = self._ended or ClientClosed("the client was closed")
        self._fail(self._ended)
        self._thread.shutdown(wait=False)

    def _leave_order(self) -> None:
        if self._ordered is not None:
            self._ordered.leave(self)
        self._ordered = None
        if self._asked:
            self._answer()

    def on_quiet(self, timer: float) -> bool:
        """Advance time, as no task is ready to run; return whether anything can still happen."""
        if self._fatal is not None:
            fatal, self._fatal = self._fatal, None
            self._leave_order()
            raise fatal
        if self._asked and not self._driving:
            self._answer()
        elif not (self._driving or self._holds):
            until = min([timer, *(wait.until for wait in self._waits)])
            if not self._waits and timer == math.inf:
                return False
            self._advance(until)
        return True

    def _look_later(self) -> None:
        if self._lockstep is not None and self._ordered is None and not (self._looking or self._driving):
            self._looking, self._passes = True, 0
            self._loop.call_soon(self._look)

    def _look(self) -> None:
        """Advance time if no task was ready to run for some passes of the loop."""
        self._passes += 1
        if self._passes < _PASSES:
            self._loop.call_soon(self._look)
            return
        self._looking = False
        if self._waits and not self._holds:
            self._advance(min(wait.until for wait in self._waits))

    def _advance(self, until: float) -> None:
        self._driving, self.woken = True, False
        self._loop.run_in_executor(self._thread, self._drive, until).add_done_callback(self._on_driven)

    def _drive(self, until: float) -> float:
        lockstep = self._lockstep
        if lockstep is None:
            raise AssertionError
        self._driver = threading.get_ident()
        try:
            if until == math.inf:
                lockstep.drive(lambda: self.woken, None)
            else:
                lockstep.drive_within(lambda: self.woken, None, max(until - lockstep.now, 0.0))
        finally:
            # Samples published before the grant have arrived before it.
            for subscription in list(self._subscriptions):
                subscription.settle()
        return lockstep.now

    def _on_driven(self, driven: asyncio.Future[float]) -> None:
        """End the waits that are due, or fail all of them if time can't advance."""
        with self._posting:
            self._driving, self._driver = False, None
            posted, self._posted = self._posted, []
        for _, call in sorted(posted, key=itemgetter(0)):
            call()
        if self._lockstep is not None:
            self.loop_time = self._lockstep.now
        if error := driven.exception():
            if self._lockstep is None or self._lockstep.lost or not self._waits:
                # A task that sleeps by the loop's own clock can't be detected.
                self._fatal = None if self._waits else error
                if self._waits:
                    self._leave_order()
            self._fail(error)
            return
        for wait in sorted(self._waits, key=lambda each: each.until):
            if wait.until <= driven.result():
                wait.finish()
        if self._lockstep is not None and self._lockstep.over:
            self._leave_lockstep(self._lockstep, driven.result())
        elif self._waits:
            self._look_later()

    def _leave_lockstep(self, lockstep: Lockstep, now: float) -> None:
        """Continue with time that moves by itself, or fail all waits if the run has ended."""
        self._leave_order()
        self._lockstep = None
        if lockstep.ended is not None:
            # A request of another task may have closed lockstep, so that the drive ends without an error.
            self._ended = lockstep.ended
            self._fail(self._ended)
            return
        for wait in self._waits:
            if wait.until < math.inf:
                wait.set_alarm(self._client, max(wait.until - now, 0.0))
        self._look_around_later()

    def _fail(self, error: BaseException) -> None:
        for wait in list(self._waits):
            wait.finish(error)

    def _look_around_later(self) -> None:
        if not self._looks_around:
            self._looks_around = True
            self._loop.call_later(_LOOK_AROUND, self._look_around)

    def _look_around(self) -> None:
        """Fail all waits if the simulator is gone, or cancel the client's task if no wait or call reports that."""
        self._looks_around = False
        if self._ended is not None:
            return
        if absence := self._client.absence:
            if self._waits:
                self._has_failed = True
                self._fail(absence)
            elif isinstance(absence, SimulatorGone) and self._task and not (self._holds or self._has_failed):
                self._has_failed = True
                self.lost = absence
                self._task.cancel()
        self._look_around_later()


def _results_of(calls: Sequence[Callable[[], Any]]) -> list[tuple[Any, BaseException | None]]:
    """Return what each of some calls returns, or the error that it raises."""
    results: list[tuple[Any, BaseException | None]] = []
    for call in calls:
        try:
            results.append((call(), None))
        except BaseException as error:  # noqa: BLE001 - the task that asked handles it
            results.append((None, error))
    return results
