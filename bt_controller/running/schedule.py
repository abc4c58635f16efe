"""The schedule of ticks: when a tree has to be ticked without an event of its goals, and the queue of those times.

In lockstep, the simulator also stops time for conditions that trees wait for, so that no tree is ticked in between.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from functools import cache, partial
from heapq import heappop, heappush
from typing import TYPE_CHECKING, Any, NamedTuple

from py_trees import decorators
from py_trees.common import Status
from py_trees.composites import Parallel, Selector, Sequence
from py_trees.timers import Timer

from bt_controller.behaviours.subscribers import Handler
from bt_controller.core.action_leaf import ActionLeaf
from bt_controller.core.node import EACH_PERIOD, Node
from bt_controller.core.sim_time import NANOSECONDS, nanoseconds

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour

    from bt_controller.core.topics import Topics
    from hmrsim_zenoh.client.conditions import Condition
    from hmrsim_zenoh.client.lockstep import Lockstep
    from hmrsim_zenoh.errors import RequestError


class Due(NamedTuple):
    """When a running tree has to be ticked.

    Attributes:
        time: The latest time, in simulated seconds; infinite for never.
        awaited: The conditions whose coming true it has to be ticked for before, in the order of its nodes.
    """

    time: float
    awaited: list[Condition]


def due(root: Behaviour, now: float, period: float) -> Due:
    """Return when a running tree has to be ticked.

    Goals tell when they have ended, timers when they will, and nodes of XML trees when they have to look again.
    Whatever else a tick would look at, it has to be looked at each *period*; the periods count from zero, so that
    all trees are ticked at the same instants.
    """
    polled, deadline = False, math.inf
    awaited: list[Condition] = []
    looked_at: list[tuple[Any, float]] = [(root, 0.0)]
    while looked_at:
        node, behind = looked_at.pop()
        kind = _kind(node.__class__)
        if kind.xml:
            look = node.next_tick_time()
            polled = polled or look == EACH_PERIOD
            deadline = min(deadline, look + behind) if look != EACH_PERIOD else deadline
            awaited += node.awaited()
            behind += node.behind
            looked_at += [(child, behind) for child in node.next_ticked()]
            continue
        if node.status is not Status.RUNNING:
            # The node would start again, with an unknown result.
            polled = True
            continue
        conditions = node.awaited() if kind.reads else ()
        awaited += conditions
        polled = polled or not (kind.waits or conditions)
        if kind.timed:
            deadline = min(deadline, node.finish_time + behind)
        looked_at += [(child, behind) for child in _next_ticked(node, kind)]
    if deadline != math.inf and nanoseconds(deadline) <= nanoseconds(now):
        # It was polled just now.
        polled, deadline = True, math.inf
    return Due(min(deadline, next_period(now, period)) if polled else deadline, awaited)


class _Kind(NamedTuple):
    """The properties of a class of behaviors, since checking classes of py_trees takes a while.

    Attributes:
        xml: Whether it is a node of XML trees, which says itself when it has to be ticked.
        waits: Whether a running one changes only through its children, its goal or its time.
        reads: Whether it reads a topic, and may wait for conditions on it.
        timed: Whether it has a time at which it ends.
        in_turn: Whether its children run one after the other.
        parallel: Whether they run side by side.
    """

    xml: bool
    waits: bool
    reads: bool
    timed: bool
    in_turn: bool
    parallel: bool


@cache
def _kind(kind: type[Behaviour]) -> _Kind:
    return _Kind(
        xml=issubclass(kind, Node),
        waits=_waits(kind),
        reads=issubclass(kind, Handler),
        timed=issubclass(kind, (Timer, decorators.Timeout)),
        in_turn=issubclass(kind, (Sequence, Selector)),
        parallel=issubclass(kind, Parallel),
    )


def _waits(kind: type[Behaviour]) -> bool:
    if issubclass(kind, ActionLeaf):
        return kind.update is ActionLeaf.update
    if kind.__module__ == decorators.__name__:
        # A guard evaluates a function of the user at each tick.
        return kind is not decorators.EternalGuard
    return kind in (Sequence, Selector, Parallel, Timer)


def _next_ticked(node: Any, kind: _Kind) -> list[Behaviour]:
    """Return the children that the next tick of a running node would tick."""
    children: list[Behaviour] = node.children
    if kind.in_turn and node.current_child is not None:
        last = children.index(node.current_child)
        return children[last if node.memory else 0 : last + 1]
    if kind.parallel and node.policy.synchronise:
        return [child for child in children if child.status is not Status.SUCCESS]
    return children


def next_period(now: float, period: float) -> float:
    """Return when the next period of simulated time begins."""
    step = nanoseconds(period)
    return (nanoseconds(now) // step + 1) * step / NANOSECONDS


class TimerQueue:
    """A time for each number, in simulated seconds; infinite for never, the initial value."""

    def __init__(self) -> None:
        self._times: dict[int, int] = {}
        # All times that were ever put; replaced ones are skipped when they come up.
        self._heap: list[tuple[int, int]] = []

    def put(self, who: int, time: float) -> None:
        """Set the time of a number, replacing any earlier one."""
        if time == math.inf:
            self._times.pop(who, None)
        elif self._times.get(who) != (whole := nanoseconds(time)):
            self._times[who] = whole
            heappush(self._heap, (whole, who))

    @property
    def earliest(self) -> float:
        """The earliest time of all numbers."""
        while self._heap and self._times.get(self._heap[0][1]) != self._heap[0][0]:
            heappop(self._heap)
        return self._heap[0][0] / NANOSECONDS if self._heap else math.inf

    def pop_due(self, now: float) -> list[int]:
        """Return and remove the numbers that are due."""
        come = []
        while self.earliest <= nanoseconds(now) / NANOSECONDS:
            come.append(heappop(self._heap)[1])
            del self._times[come[-1]]
        return come


class Alarms:
    """The conditions that each tree waits for.

    Args:
        lockstep: Has conditions watched.
        topics: Learns which can't be.
        wake: Called with a tree's name when one of its conditions is met, or can't be watched.
    """

    def __init__(self, lockstep: Lockstep, topics: Topics, wake: Callable[[str], None]) -> None:
        self._lockstep = lockstep
        self._topics = topics
        self._wake = wake
        self._waiting: dict[str, dict[Condition, Callable[[], None]]] = {}

    def set(self, name: str, conditions: Iterable[Condition]) -> None:
        """Wake a tree for these conditions and no others; the next advance tells the simulator."""
        waiting = self._waiting.setdefault(name, {})
        wanted = dict.fromkeys(conditions)
        for needless in [condition for condition in waiting if condition not in wanted]:
            waiting.pop(needless)()
        for condition in wanted:
            if condition not in waiting:
                waiting[condition] = self._lockstep.watch(condition, partial(self._end, name, condition))

    def clear(self) -> None:
        """Wake no tree; after a reset they wait for something else."""
        for name in self._waiting:
            self.set(name, ())

    def _end(self, name: str, condition: Condition, error: RequestError | None) -> None:
        self._waiting[name].pop(condition, None)
        if error is not None:
            self._topics.poll(condition.key)
        self._wake(name)
