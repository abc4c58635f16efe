"""What can happen to a node at its place in a tree, as far as that is known without running it.

What a composite can return follows from its children. A node can be canceled if one above it halts running children,
and a failure can be recovered if one above it tries something else, or the same again.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from bt_controller.coverage.kinds import Outcomes, kind_of, outcomes_of_leaf
from bt_controller.coverage.outcomes import CANCELED, FAILURE, RECOVERED, RUNNING

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour


def possible_outcomes(root: Behaviour) -> Iterator[tuple[Behaviour, Outcomes]]:
    """Yield the nodes of a tree, parents first, with what can happen to each of them."""
    returned: dict[Behaviour, Outcomes] = {}
    _returns(root, returned)
    yield from _marked(root, returned, halted=False, recovered=False)


def recovers(node: Behaviour) -> bool:
    """Return whether a node makes up for a failure of one of its children."""
    count = len(node.children)
    return any(kind_of(node).recovers(index, count) for index in range(count))


def _marked(
    node: Behaviour, returned: Mapping[Behaviour, Outcomes], *, halted: bool, recovered: bool
) -> Iterator[tuple[Behaviour, Outcomes]]:
    found = returned[node]
    canceled = {CANCELED} if halted and RUNNING in found else set[str]()
    yield node, found | canceled | ({RECOVERED} if recovered and FAILURE in found else set[str]())
    kind, count = kind_of(node), len(node.children)
    for index, child in enumerate(node.children):
        yield from _marked(
            child,
            returned,
            halted=halted or kind.halts(index, count),
            recovered=kind.recovers(index, count) or (recovered and not kind.swallows(index, count)),
        )


def _returns(node: Behaviour, returned: dict[Behaviour, Outcomes]) -> Outcomes:
    children = [_returns(child, returned) for child in node.children]
    found = kind_of(node).returns(children) if children else outcomes_of_leaf(type(node))
    returned[node] = found
    return found
