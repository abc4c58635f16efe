"""The time of the next tick of a tree without events of its goals."""

from __future__ import annotations

import math
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

from py_trees import decorators
from py_trees.common import Status
from py_trees.composites import Parallel, Selector, Sequence
from py_trees.timers import Timer

from bt_controller.core.action_leaf import ActionLeaf
from bt_controller.core.node import EACH_PERIOD, Node
from bt_controller.core.sim_time import NANOSECONDS, nanoseconds

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour


def due(root: Behaviour, now: float, period: float) -> float:
    """Return when a running tree has to be ticked at the latest, in simulated seconds; infinite for never.

    Goals tell when they have ended, timers when they will, and nodes of XML trees when they have to look again.
    Whatever else a tick would look at, it has to be looked at each *period*; the periods count from zero, so that
    all trees are ticked at the same instants.
    """
    polled, deadline = False, math.inf
    looked_at: list[tuple[Any, float]] = [(root, 0.0)]
    while looked_at:
        node, behind = looked_at.pop()
        kind = _kind(node.__class__)
        if kind.xml:
            look = node.next_tick_time()
            polled = polled or look == EACH_PERIOD
            deadline = min(deadline, look + behind) if look != EACH_PERIOD else deadline
            behind += node.behind
            looked_at += [(child, behind) for child in node.next_ticked()]
            continue
        if node.status is not Status.RUNNING:
            # The node would start again, with an unknown result.
            polled = True
            continue
        polled = polled or not kind.waits
        if kind.timed:
            deadline = min(deadline, node.finish_time + behind)
        looked_at += [(child, behind) for child in _next_ticked(node, kind)]
    if deadline != math.inf and nanoseconds(deadline) <= nanoseconds(now):
        # It was polled just now.
        polled, deadline = True, math.inf
    return min(deadline, next_period(now, period)) if polled else deadline


class _Kind(NamedTuple):
    """What a class of behaviours is, which takes a while to find out of classes as py_trees' are.

    Attributes:
        xml: Whether it is a node of XML trees, which says itself when it has to be ticked.
        waits: Whether a running one changes only through its children, its goal or its time.
        timed: Whether it has a time at which it ends.
        in_turn: Whether its children run one after the other.
        parallel: Whether they run side by side.
    """

    xml: bool
    waits: bool
    timed: bool
    in_turn: bool
    parallel: bool


@cache
def _kind(kind: type[Behaviour]) -> _Kind:
    return _Kind(
        xml=issubclass(kind, Node),
        waits=_waits(kind),
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
