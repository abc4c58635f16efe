"""What can happen to a node at its place in a tree, as far as that is known without running it.

What a composite can return follows from its children. A node can be canceled if one above it halts running children,
and a failure can be recovered if one above it tries something else, or the same again.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import repeat
from typing import TYPE_CHECKING, Final

from bt_controller.coverage.kinds import Outcomes, kind_of, outcomes_of_leaf
from bt_controller.coverage.outcomes import CANCELED, FAILURE, RECOVERED, RUNNING

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour

_CANCELED: Final = frozenset({CANCELED})
_RECOVERED: Final = frozenset({RECOVERED})


def possible_outcomes(root: Behaviour) -> dict[Behaviour, Outcomes]:
    """Return what can happen to each node of a tree; parents come first."""
    returned: dict[Behaviour, Outcomes] = {}
    _returns(root, returned)
    found: dict[Behaviour, Outcomes] = {}
    _mark(root, returned, found, halted=False, recovered=False)
    return found


def recovers(node: Behaviour) -> bool:
    """Return whether a node makes up for a failure of one of its children."""
    count = len(node.children)
    return count > 0 and any(map(kind_of(node).recovers, range(count), repeat(count)))


def _mark(
    node: Behaviour,
    returned: Mapping[Behaviour, Outcomes],
    found: dict[Behaviour, Outcomes],
    *,
    halted: bool,
    recovered: bool,
) -> None:
    """Find what can happen to a node and those below it, by what can happen above it."""
    outcomes = returned[node]
    if halted and RUNNING in outcomes:
        outcomes |= _CANCELED
    if recovered and FAILURE in outcomes:
        outcomes |= _RECOVERED
    found[node] = outcomes
    if not (count := len(node.children)):
        return
    kind = kind_of(node)
    for index, child in enumerate(node.children):
        may_halt = halted or kind.halts(index, count)
        may_recover = kind.recovers(index, count) or (recovered and not kind.swallows(index, count))
        _mark(child, returned, found, halted=may_halt, recovered=may_recover)


def _returns(node: Behaviour, returned: dict[Behaviour, Outcomes]) -> Outcomes:
    if node.children:
        found = kind_of(node).returns([_returns(child, returned) for child in node.children])
    else:
        found = outcomes_of_leaf(type(node))
    returned[node] = found
    return found
