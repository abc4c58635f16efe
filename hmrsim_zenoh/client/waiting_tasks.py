"""Tasks that wait for each other for ever: for what, where, of which robots, and who holds their locks."""

from __future__ import annotations

import asyncio
import asyncio.locks
import inspect
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any, Final, Literal

from hmrsim.program.users_code import place_in

if TYPE_CHECKING:
    from types import FrameType

_MOST_NAMED: Final = 10


class NamedRobot:
    """A client of one robot, which texts name beside each task that has it as an argument.

    Attributes:
        name: The robot's name.
    """

    name: str


class Lock(asyncio.Lock):
    """A lock that knows the task that has acquired it.

    Attributes:
        holder: The task that has acquired it last; None before.
        holder_text: Its name, with those of its robots.
    """

    holder: asyncio.Task[Any] | None = None
    holder_text: str = ""

    async def acquire(self) -> Literal[True]:
        """Wait until the lock is free, and acquire it."""
        await super().acquire()
        self.holder = asyncio.current_task()
        if self.holder is not None:
            self.holder_text = _named(self.holder, [*_stack(inspect.currentframe())])
        return True


def record_holders() -> None:
    """Make `asyncio.Lock` a lock that knows its holder, also for a `asyncio.Condition`."""
    for module in (asyncio, asyncio.locks):
        vars(module)["Lock"] = Lock


def waits_of(tasks: Iterable[asyncio.Task[Any]]) -> str:
    """Return a text that names tasks, and for what and where they wait; first those that wait for a lock."""
    chains = [(task, [*_frames(task)]) for task in tasks]
    chains.sort(key=lambda each: _lock_in(each[1]) is None)
    waiting = [f"{_named(task, frames)}{_wait_of(task, frames)}" for task, frames in chains]
    more = len(waiting) - _MOST_NAMED
    return "; ".join(waiting[:_MOST_NAMED]) + (f"; and {more} more" if more > 0 else "")


def _named(task: asyncio.Task[Any], frames: Iterable[FrameType]) -> str:
    """Return the name of a task, with the robots among the arguments of its coroutines, unless it is their name."""
    robots: dict[str, None] = {}
    for frame in frames:
        code = frame.f_code
        for argument in code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]:
            value = frame.f_locals.get(argument)
            robot = value.__self__ if inspect.ismethod(value) else value
            if isinstance(robot, NamedRobot):
                robots[robot.name] = None
    name = task.get_name()
    return name if not robots or [*robots] == [name] else f"{name} ({', '.join(robots)})"


def _stack(frame: FrameType | None) -> Iterator[FrameType]:
    """Yield the frames of the running task, the innermost first."""
    while frame is not None and frame.f_globals.get("__name__") != "asyncio.events":
        yield frame
        frame = frame.f_back


def _frames(task: asyncio.Task[Any]) -> Iterator[FrameType]:
    """Yield the frames of a task that waits, the outermost first; none if it has not begun."""
    awaited: Any = task.get_coro()
    while awaited is not None:
        kind = next((each for each in ("cr", "gi", "ag") if hasattr(awaited, f"{each}_frame")), None)
        if kind is None:
            return
        if frame := getattr(awaited, f"{kind}_frame"):
            yield frame
        awaited = getattr(awaited, "gi_yieldfrom" if kind == "gi" else f"{kind}_await")


def _lock_in(frames: Iterable[FrameType]) -> asyncio.Lock | None:
    """Return the lock for which a task waits."""
    acquiring = (frame.f_locals.get("self") for frame in frames if frame.f_code.co_name == "acquire")
    return next((lock for lock in acquiring if isinstance(lock, asyncio.Lock)), None)


def _wait_of(task: asyncio.Task[Any], frames: list[FrameType]) -> str:
    """Return for what a task waits, and where, in the user's code if it is there; empty if it has not begun."""
    place = place_in([(frame.f_code.co_filename, frame.f_lineno) for frame in frames])
    of_asyncio = [frame for frame in frames if frame.f_globals.get("__name__", "").startswith("asyncio.")]
    public = [name for frame in of_asyncio if not (name := frame.f_code.co_qualname).startswith("_")]
    waiter = getattr(task, "_fut_waiter", None)
    what = ""
    if public:
        what = f" waits in {public[-1]}"
    elif isinstance(waiter, asyncio.Task):
        what = f" waits for {waiter.get_name()}"
    elif waiter is not None:
        what = f" waits for {'gather' if 'Gathering' in type(waiter).__name__ else 'a future'}"
    lock = _lock_in(frames)
    return f"{what}{f' ({place})' if place else ''}{_held(lock, task) if isinstance(lock, Lock) else ''}"


def _held(lock: Lock, waiting: asyncio.Task[Any]) -> str:
    """Return who holds the lock for which a task waits."""
    if lock.holder is None:
        return ""
    if lock.holder is waiting:
        return " for a lock that it holds itself"
    ended = ", which has ended without releasing it" if lock.holder.done() else ""
    return f" for a lock that {lock.holder_text} holds{ended}"
