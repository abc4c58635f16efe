"""An event loop that runs tasks in the same order each time, by the clock of the simulation.

asyncio keeps tasks, futures and asynchronous generators in sets. Their order is that of addresses in memory, so the
order in which a group cancels its tasks, or in which `asyncio.wait` returns them, differs between processes. An ordered
loop numbers them as they are made, and their hash is that number.
"""

from __future__ import annotations

import asyncio
import asyncio.tasks
import builtins
import gc
import itertools
import math
import re
import threading
from collections.abc import Coroutine, Iterable, Iterator
from typing import TYPE_CHECKING, Any, Final, Protocol
from weakref import WeakKeyDictionary

from hmrsim_zenoh.client.waiting_tasks import record_holders, waits_of
from hmrsim_zenoh.errors import Deadlock

if TYPE_CHECKING:
    from collections.abc import Callable

_HARMLESS: Final = ("MainThread", "hmrsim", "asyncio_")
"""The beginnings of the names of threads that wake no task of a user: those of clients, and of idle executors."""
_OWN_SUBSCRIPTION: Final = "/_world/events"
_COLLECT_EVERY: Final = 1000
"""Advances of time after which garbage is collected.

A collected task or generator may run code, and the time of an automatic collection depends on all that the process has
done before.
"""
_LAST_WORDS: Final = 10.0
"""Seconds after which Python collects garbage automatically again, if a loop continues without a client."""
_BEFORE: Final = frozenset(threading.enumerate())


class Clock(Protocol):
    """The time of a client's tasks.

    Attributes:
        loop_time: Simulated seconds.
    """

    loop_time: float

    def on_quiet(self, timer: float) -> bool:
        """Advance time, as no task is ready to run; return whether anything can still happen.

        Args:
            timer: When the first timer of the loop is due, in simulated seconds; infinite without one.
        """


class OrderedFuture(asyncio.Future[Any]):
    """A future whose hash is its number."""

    def __init__(self, number: int, loop: asyncio.AbstractEventLoop) -> None:
        self._number = number
        super().__init__(loop=loop)

    def __hash__(self) -> int:
        """Return its number."""
        return self._number


class OrderedTask(asyncio.Task[Any]):
    """A task whose hash is its number.

    Attributes:
        number: The number of tasks and futures that its loop had made when it made this one.
    """

    def __init__(
        self, number: int, coroutine: Coroutine[Any, Any, Any], loop: asyncio.AbstractEventLoop, **options: Any
    ) -> None:
        # The constructor of a task puts it into a set already.
        self.number = number
        super().__init__(coroutine, loop=loop, **options)

    def __hash__(self) -> int:
        """Return its number."""
        return self.number


class Tasks(set["asyncio.Task[Any]"]):
    """Tasks in the order in which they were made; first those that were made before their loop was ordered."""

    def __iter__(self) -> Iterator[asyncio.Task[Any]]:
        """Return an iterator in this order."""
        return iter(sorted(super().__iter__(), key=_age))

    def __sub__(self, other: Any) -> Any:
        """Return the tasks that are not in another set."""
        return Tasks(super().__sub__(other))


class _Generators(WeakKeyDictionary[Any, None]):
    """Asynchronous generators in the order in which they began, with the methods that a loop needs."""

    def add(self, generator: object) -> None:
        self[generator] = None

    def discard(self, generator: object) -> None:
        self.pop(generator, None)


class OrderedLoop(asyncio.SelectorEventLoop):
    """An event loop that numbers its tasks and futures, and whose timers ring by simulated time.

    `asyncio.run` makes its loop before a client connects: `of` makes that loop ordered.
    """

    # Attributes of asyncio that its type stubs lack.
    _ready: Any
    _scheduled: Any
    _selector: Any
    _signal_handlers: Any
    _internal_fds: int
    _clock_resolution: float
    _stopping: bool
    _asyncgens: Any

    @staticmethod
    def of(loop: asyncio.AbstractEventLoop) -> OrderedLoop | None:
        """Return a running loop as an ordered one; None if it is of another kind, such as that of uvloop."""
        if isinstance(loop, OrderedLoop):
            return loop
        if type(loop) is not asyncio.SelectorEventLoop:
            return None
        loop.__class__ = OrderedLoop
        return loop._ordered() if isinstance(loop, OrderedLoop) else None  # noqa: SLF001 - it is its constructor

    def _ordered(self) -> OrderedLoop:
        self._numbers = itertools.count(1)
        self._clocks: list[Clock] = []
        self._jobs: list[asyncio.Future[Any]] = []
        self._quiet = 0
        self._collects = False
        # Zenoh's threads, too, which are not started by Python.
        self._known = _BEFORE.union(each for each in threading.enumerate() if type(each) is not threading.Thread)
        began, self._asyncgens = list(self._asyncgens), _Generators()
        for generator in began:
            self._asyncgens.add(generator)
        if self.get_task_factory() is None:
            self.set_task_factory(_make_task)  # type: ignore[arg-type]
        for task in sorted(_all_tasks(self), key=_age):
            if _UNNAMED.fullmatch(task.get_name()):
                task.set_name(f"Task-{next(self._numbers)}")
        _order_sets()
        record_holders()
        return self

    def next_number(self) -> int:
        """Return the number of a new task or future."""
        return next(self._numbers)

    def create_future(self) -> asyncio.Future[Any]:
        """Return a future whose hash is its number."""
        return OrderedFuture(next(self._numbers), self)

    def run_in_executor(  # type: ignore[override]
        self, executor: Any, func: Callable[..., Any], *args: Any
    ) -> asyncio.Future[Any]:
        """Call a function in a thread; tasks that wait for it do not count as deadlocked."""
        job = super().run_in_executor(executor, func, *args)
        self._jobs = [each for each in self._jobs if not each.done()]
        self._jobs.append(job)
        return job

    def time(self) -> float:
        """Return simulated seconds while a client takes part in lockstep; else those of the machine."""
        return self._clocks[0].loop_time if self._clocks else super().time()

    def enter(self, clock: Clock) -> None:
        """Use the simulated time of a client from now on."""
        if gc.isenabled():
            gc.disable()
            self._collects = True
        before = self.time()
        self._clocks.append(clock)
        self._shift_timers(self.time() - before)

    def leave(self, clock: Clock) -> None:
        """Stop using the simulated time of a client."""
        if clock in self._clocks:
            before = self.time()
            self._clocks.remove(clock)
            self._shift_timers(self.time() - before)
            if self._collects and not self._clocks:
                self.call_later(_LAST_WORDS, self._collect_again)

    def close(self) -> None:
        """Close the loop; Python collects garbage by itself again."""
        super().close()
        self._clocks.clear()
        self._collect_again()

    def _collect_again(self) -> None:
        if self._collects and not self._clocks:
            gc.enable()
            self._collects = False

    def _shift_timers(self, seconds: float) -> None:
        for timer in self._scheduled:
            timer._when += seconds  # noqa: SLF001 - all by as much, so that the heap stays one

    def _run_once(self) -> None:
        """Run the tasks that are ready; if there are none, advance time first."""
        if self._clocks and not self._ready and not self._stopping:
            self._on_quiet()
        super()._run_once()  # type: ignore[misc]

    def _on_quiet(self) -> None:
        timer = min((each.when() for each in self._scheduled if not each.cancelled()), default=math.inf)
        if timer < self.time() + self._clock_resolution:
            return
        self._quiet += 1
        if self._collects and not self._quiet % _COLLECT_EVERY:
            gc.collect()
            if self._ready:
                return
        # Each of them is asked.
        busy = [clock.on_quiet(timer) for clock in self._clocks]
        if not any(busy) and not self._can_be_woken():
            why = "no task is ready, and none waits for the simulator, a timer, a thread or a file"
            raise Deadlock(f"deadlock: {why}: {waits_of(asyncio.all_tasks(self))}")

    def _can_be_woken(self) -> bool:
        """Return whether something other than the simulation may wake a task: a thread, a file, a signal."""
        if any(not job.done() for job in self._jobs) or self._signal_handlers:
            return True
        if len(self._selector.get_map()) > self._internal_fds:
            return True
        return any(_wakes_tasks(each) for each in threading.enumerate() if each not in self._known)


def _wakes_tasks(thread: threading.Thread) -> bool:
    return not (thread.name.startswith(_HARMLESS) or thread.name.endswith(_OWN_SUBSCRIPTION))


def _make_task(
    loop: asyncio.AbstractEventLoop, coroutine: Coroutine[Any, Any, Any], **options: Any
) -> asyncio.Task[Any]:
    if not isinstance(loop, OrderedLoop):
        raise TypeError(f"expected an ordered loop, got {loop!r}")
    # Python's own names count the tasks of the whole process.
    number = loop.next_number()
    return OrderedTask(number, coroutine, loop, **{"name": f"Task-{number}", **options})


def _age(task: asyncio.Task[Any]) -> tuple[int, int, str]:
    """Return a key by which tasks that were made before their loop was ordered come first, by number or name."""
    if isinstance(task, OrderedTask):
        return task.number, 0, ""
    unnamed = _UNNAMED.fullmatch(name := task.get_name())
    return 0, int(unnamed[1]) if unnamed else 0, name


_UNNAMED: Final = re.compile(r"Task-(\d+)")
"""The names of tasks without a name of their own, which count the tasks of the whole process."""

_all_tasks = asyncio.tasks.all_tasks


def all_tasks(loop: asyncio.AbstractEventLoop | None = None) -> set[asyncio.Task[Any]]:
    """Return the tasks of a loop that have not ended; those of an ordered loop in the order in which they were made."""
    loop = loop or asyncio.get_running_loop()
    tasks = _all_tasks(loop)
    return Tasks(tasks) if isinstance(loop, OrderedLoop) else tasks


def _unique(awaitables: Iterable[Any] = ()) -> Any:
    """Return awaitables once each: coroutines, of which nothing but the address can be a hash, in their order."""
    items = list(awaitables)
    return dict.fromkeys(items) if any(map(asyncio.iscoroutine, items)) else builtins.set(items)


def _number_of(gathered: asyncio.Future[Any]) -> int:
    """Return the hash of a future that `asyncio.gather` has returned."""
    number: int | None = getattr(gathered, "_number", None)
    if number is None:
        loop = gathered.get_loop()
        number = loop.next_number() if isinstance(loop, OrderedLoop) else object.__hash__(gathered)
        gathered._number = number  # type: ignore[attr-defined]  # noqa: SLF001 - it is as its method
    return number


def _order_sets() -> None:
    """Make asyncio's own functions keep the order.

    `asyncio.as_completed` starts coroutines in the order of a set. The set of all tasks includes those that
    `asyncio.run` made before the loop was ordered. The futures of `asyncio.gather` are not made by the loop.
    """
    names = vars(asyncio.tasks)
    names["_GatheringFuture"].__hash__ = _number_of
    names["set"] = _unique
    names["all_tasks"] = all_tasks
    vars(asyncio)["all_tasks"] = all_tasks
