"""The time of the next tick of a tree without events of its goals."""

from __future__ import annotations

import math
from functools import cache
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

    from hmrsim_zenoh.client.conditions import Condition


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
    """What a class of behaviors is, which takes a while to find out of classes as py_trees' are.

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
