"""Recording of a tree while it is ticked.

Without coverage this costs nothing. With coverage each tick costs a count for each node that is ticked. Halts are noted
by each node's ``stop``, and suspensions by each action leaf's ``suspend``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, TypeAlias

from py_trees.common import Status

from bt_controller.core.action_leaf import ActionLeaf
from bt_controller.core.node import Node
from bt_controller.core.subtrees import paths
from bt_controller.coverage.kinds import possible_outcomes, recovers
from bt_controller.coverage.node_coverage import (
    CANCELED,
    FAILURE,
    RECOVERED,
    RUNNING,
    SKIPPED,
    SUCCESS,
    NodeCoverage,
    ended_with_run,
    ending_of,
)

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour

    from hmrsim_zenoh.client.goal_handle import GoalHandle

Counted: TypeAlias = "tuple[Behaviour, bool, NodeCoverage]"
"""A node, whether a node above it may make up for its failure, and what is counted of it."""

_SELF: Final = "{robot}"


def watched(root: Behaviour, robot: str | None) -> Iterator[tuple[Behaviour, NodeCoverage]]:
    """Yield the nodes of a tree, parents first, with nothing counted; the robot's name in paths is ``{robot}``."""
    possible = possible_outcomes(root)
    own = None if robot is None else re.compile(rf"\b{re.escape(robot)}\b")
    places: dict[Behaviour, tuple[int, ...]] = {root: ()}
    for node, path in paths(root):
        for index, child in enumerate(node.children):
            places[child] = (*places[node], index)
        shown = path if own is None else own.sub(_SELF, path)
        origin = node.origin if isinstance(node, Node) else ""
        yield node, NodeCoverage(places[node], shown, type(node).__name__, origin, possible[node])


@dataclass(eq=False)
class _Seen:
    """A node of the recorded tree.

    Attributes:
        number: Its number, parents before their children.
        end: The number after that of the last node below it.
        covered: Its counts.
        recoverable: Whether a node above it may make up for its failure.
        recovers: Whether it makes up for failures of its children.
        handle: The goal whose end was counted last.
        halted: In which tick it was halted last.
    """

    number: int
    end: int
    covered: NodeCoverage
    recoverable: bool
    recovers: bool
    leaf: ActionLeaf[Any, Any, Any] | None
    handle: GoalHandle[Any, Any] | None = None
    halted: int = 0


def _measure(node: Behaviour, sizes: dict[Behaviour, int]) -> int:
    """Note how many nodes each subtree has."""
    size = sizes[node] = 1 + sum([_measure(child, sizes) for child in node.children])
    return size


class Recorder:
    """Ticks a tree, and counts what happens to its nodes.

    Args:
        root: The tree, before its first tick.
        counted: Returns the tree's nodes and what is counted of them; called again if the tree has grown.
    """

    def __init__(self, root: Behaviour, counted: Callable[[], Sequence[Counted]]) -> None:
        self._root = root
        self._counted = counted
        self._seen: dict[Behaviour, _Seen] = {}
        self._by_number: list[_Seen] = []
        self._failed: set[int] = set()
        self._ended = False
        self._ticks = 0
        self._look()

    def tick(self) -> None:
        """Tick the tree once."""
        if self._ended:
            self._root.tick_once()
            return
        self._ticks += 1
        for node in self._root.tick():
            if not self._ended:
                self._note(node)

    def end(self) -> None:
        """Stop counting: behaviors that stop now are stopped with the run, not by the tree."""
        self._ended = True

    def covered(self, node: Behaviour) -> NodeCoverage:
        """Return what was counted of a node so far, in all trees with this node."""
        return self._of(node).covered

    def _note(self, node: Behaviour) -> None:
        """Count the result of a tick."""
        seen = self._seen.get(node) or self._of(node)
        status, counts = node.status, seen.covered.counts
        if status is Status.RUNNING:
            counts[RUNNING] += 1
            return
        if seen.leaf is not None:
            if ended_with_run(seen.leaf.handle):
                self.end()
                return
            self._note_goal(seen, seen.leaf.handle)
        if status is Status.SUCCESS:
            counts[SUCCESS] += 1
            if seen.recovers and self._failed:
                self._recovered(seen)
        elif status is Status.FAILURE:
            counts[FAILURE] += 1
            if seen.recoverable:
                self._failed.add(seen.number)
            elif seen.number == 0:
                self._failed.clear()
        else:
            counts[SKIPPED] += 1
            # It was running and has found that it is to be skipped: its parent did not halt it.
            counts[CANCELED] -= seen.halted == self._ticks

    @staticmethod
    def _note_goal(seen: _Seen, handle: GoalHandle[Any, Any] | None) -> None:
        """Count how a goal has ended, once."""
        if handle is not None and handle is not seen.handle and handle.done:
            seen.handle = handle
            if ending := ending_of(handle):
                seen.covered.counts[ending] += 1

    def _recovered(self, above: _Seen) -> None:
        for number in [each for each in self._failed if above.number < each < above.end]:
            self._failed.discard(number)
            self._by_number[number].covered.counts[RECOVERED] += 1

    def _halted(self, seen: _Seen) -> None:
        if not self._ended:
            seen.covered.counts[CANCELED] += 1
            seen.halted = self._ticks
            # Failures below it were not recovered.
            self._failed.difference_update(range(seen.number, seen.end))

    def _of(self, node: Behaviour) -> _Seen:
        if node not in self._seen:
            self._look()
        return self._seen[node]

    def _look(self) -> None:
        """Number the nodes, and listen to those that are new."""
        self._failed.clear()
        self._by_number.clear()
        sizes: dict[Behaviour, int] = {}
        _measure(self._root, sizes)
        for number, (node, recoverable, covered) in enumerate(self._counted()):
            leaf = node if isinstance(node, ActionLeaf) else None
            seen = _Seen(number, number + sizes[node], covered, recoverable, recovers(node), leaf)
            self._by_number.append(seen)
            if node not in self._seen:
                self._listen(node)
            self._seen[node] = seen

    def _listen(self, node: Behaviour) -> None:
        stop: Callable[[Status], None] = node.stop

        def stopped(new_status: Status = Status.INVALID) -> None:
            runs = node.status is Status.RUNNING
            stop(new_status)
            if runs and new_status is Status.INVALID:
                self._halted(self._seen[node])

        node.stop = stopped  # type: ignore[method-assign]
        if isinstance(node, ActionLeaf):
            suspend: Callable[[], None] = node.suspend

            def suspended() -> None:
                active = node.status is Status.RUNNING and node.handle is not None and not node.handle.done
                suspend()
                if active and not self._ended:
                    self._seen[node].covered.counts[CANCELED] += 1

            node.suspend = suspended  # type: ignore[method-assign]
