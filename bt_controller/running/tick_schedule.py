"""The time of the next tick of a tree without events of its goals."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

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
    looked_at = [(root, 0.0)]
    while looked_at:
        node, behind = looked_at.pop()
        if isinstance(node, Node):
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
        polled = polled or not _waits(node)
        if isinstance(node, (Timer, decorators.Timeout)):
            deadline = min(deadline, node.finish_time + behind)
        looked_at += [(child, behind) for child in _next_ticked(node)]
    if deadline != math.inf and nanoseconds(deadline) <= nanoseconds(now):
        # It was polled just now.
        polled, deadline = True, math.inf
    return min(deadline, next_period(now, period)) if polled else deadline


def _waits(node: Behaviour) -> bool:
    """Return whether a running node changes only through its children, its goal or its time."""
    kind = type(node)
    if isinstance(node, ActionLeaf):
        return kind.update is ActionLeaf.update
    if kind.__module__ == decorators.__name__:
        # A guard evaluates a function of the user at each tick.
        return kind is not decorators.EternalGuard
    return kind in (Sequence, Selector, Parallel, Timer)


def _next_ticked(node: Behaviour) -> list[Behaviour]:
    """Return the children that the next tick of a running node would tick."""
    children: list[Behaviour] = node.children
    if isinstance(node, (Sequence, Selector)) and node.current_child is not None:
        last = children.index(node.current_child)
        return children[last if node.memory else 0 : last + 1]
    if isinstance(node, Parallel) and node.policy.synchronise:
        return [child for child in children if child.status is not Status.SUCCESS]
    return children


def next_period(now: float, period: float) -> float:
    """Return when the next period of simulated time begins."""
    step = nanoseconds(period)
    return (nanoseconds(now) // step + 1) * step / NANOSECONDS
