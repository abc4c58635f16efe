"""The schedule of ticks: when a tree has to be ticked next, unless a goal ends before.

In lockstep, the simulator also watches the conditions that trees wait for, so that trees need not poll them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import lru_cache, partial
from heapq import heappop, heappush
from itertools import repeat
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from py_trees import composites, decorators
from py_trees.common import Status
from py_trees.timers import Timer

from bt_controller.behaviours.subscribers import Handler
from bt_controller.core.action_leaf import ActionLeaf
from bt_controller.core.node import EACH_PERIOD, MAX_CLASSES, Node
from bt_controller.core.sim_time import NANOSECONDS, nanoseconds

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour

    from bt_controller.core.robots import Topics
    from hmrsim_zenoh.client.connection import Condition
    from hmrsim_zenoh.client.lockstep import Lockstep
    from hmrsim_zenoh.errors import RequestError


POLL_SECONDS: Final = 1.0
"""Simulated seconds between two polls of state that has no notification."""


class Due(NamedTuple):
    """When a running tree has to be ticked next.

    Attributes:
        time: In simulated seconds; infinite for never.
        awaited: The conditions for which it has to be ticked earlier if they come true, in the order of its nodes.
    """

    time: float
    awaited: list[Condition]


def due(root: Behaviour, now: float, period: float) -> Due:
    """Return when a running tree has to be ticked next.

    The end of a goal triggers a tick, timers have a known end, and nodes of XML trees return their next tick time.
    All other nodes are polled each *period*. Periods count from time zero, so that all trees tick at the same instants.
    """
    polled, deadline = False, math.inf
    awaited: list[Condition] = []
    pending: list[tuple[Any, float]] = [(root, 0.0)]
    while pending:
        node, behind = pending.pop()
        kind = _kind(node.__class__)
        if kind.xml:
            time = node.next_tick_time()
            polled = polled or time == EACH_PERIOD
            deadline = min(deadline, time + behind) if time != EACH_PERIOD else deadline
            if kind.waits:
                continue
            awaited += node.awaited()
            behind += node.behind
            pending += zip(node.next_ticked(), repeat(behind))
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
        pending += zip(_next_ticked(node, kind), repeat(behind))
    if deadline != math.inf and nanoseconds(deadline) <= nanoseconds(now):
        # It was polled just now.
        polled, deadline = True, math.inf
    return Due(min(deadline, next_period(now, period)) if polled else deadline, awaited)


class _Kind(NamedTuple):
    """The properties of a class of behaviors, cached because checking the classes of py_trees takes a while.

    Attributes:
        xml: Whether it is a node of XML trees, which returns its next tick time.
        waits: Whether it needs no polling: only its children, its goal or its deadline change it while it runs; of a
            node of XML trees, whether it has neither children nor conditions.
        reads: Whether it reads a topic, and may wait for conditions on it.
        timed: Whether it has a deadline.
        in_turn: Whether its children run one after the other.
        parallel: Whether its children run side by side.
    """

    xml: bool
    waits: bool
    reads: bool
    timed: bool
    in_turn: bool
    parallel: bool


@lru_cache(MAX_CLASSES)
def _kind(kind: type[Behaviour]) -> _Kind:
    return _Kind(
        xml=issubclass(kind, Node),
        waits=_is_alone(kind) if issubclass(kind, Node) else _waits(kind),
        reads=issubclass(kind, Handler),
        timed=issubclass(kind, (Timer, decorators.Timeout)),
        in_turn=issubclass(kind, (composites.Sequence, composites.Selector)),
        parallel=issubclass(kind, composites.Parallel),
    )


def _is_alone(kind: type[Node]) -> bool:
    return kind.awaited is Node.awaited and kind.next_ticked is Node.next_ticked


def _waits(kind: type[Behaviour]) -> bool:
    if issubclass(kind, ActionLeaf):
        return kind.update is ActionLeaf.update
    if kind.__module__ == decorators.__name__:
        # A guard evaluates a user's function at each tick.
        return kind is not decorators.EternalGuard
    return kind in (composites.Sequence, composites.Selector, composites.Parallel, Timer)


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
    """A queue of the next tick times of trees, which are identified by numbers.

    Times are in simulated seconds; infinite, the initial value, for never.
    """

    def __init__(self) -> None:
        self._times: dict[int, int] = {}
        # Includes replaced times, which are skipped when they come up.
        self._heap: list[tuple[int, int]] = []

    def put(self, number: int, time: float) -> None:
        """Set the time of a tree, replacing its previous one."""
        if time == math.inf:
            self._times.pop(number, None)
        elif self._times.get(number) != (whole := nanoseconds(time)):
            self._times[number] = whole
            heappush(self._heap, (whole, number))

    @property
    def earliest(self) -> float:
        """The earliest time of all trees."""
        while self._heap and self._times.get(self._heap[0][1]) != self._heap[0][0]:
            heappop(self._heap)
        return self._heap[0][0] / NANOSECONDS if self._heap else math.inf

    def pop_due(self, now: float) -> list[int]:
        """Remove and return the trees that are due."""
        numbers = []
        while self._heap and self.earliest <= nanoseconds(now) / NANOSECONDS:
            numbers.append(heappop(self._heap)[1])
            del self._times[numbers[-1]]
        return numbers


class Alarms:
    """The conditions that each tree waits for.

    Args:
        lockstep: Watches the conditions.
        topics: Polls the topics of conditions that can't be watched.
        wake: Called with a tree's name when one of its conditions is met, or can't be watched.
    """

    def __init__(self, lockstep: Lockstep, topics: Topics, wake: Callable[[str], None]) -> None:
        self._lockstep = lockstep
        self._topics = topics
        self._wake = wake
        self._waiting: dict[str, dict[Condition, Callable[[], None]]] = {}

    def set(self, name: str, conditions: Sequence[Condition]) -> None:
        """Replace the conditions that wake a tree; the next advance sends them to the simulator."""
        if not conditions and name not in self._waiting:
            return
        waiting = self._waiting.setdefault(name, {})
        wanted = dict.fromkeys(conditions)
        for condition in [condition for condition in waiting if condition not in wanted]:
            waiting.pop(condition)()
        for condition in wanted:
            if condition not in waiting:
                waiting[condition] = self._lockstep.watch(condition, partial(self._end, name, condition))

    def clear(self) -> None:
        """Remove all conditions, as after a reset."""
        for name in self._waiting:
            self.set(name, ())

    def _end(self, name: str, condition: Condition, error: RequestError | None) -> None:
        self._waiting[name].pop(condition, None)
        if error is not None:
            self._topics.poll(condition.key)
        self._wake(name)
