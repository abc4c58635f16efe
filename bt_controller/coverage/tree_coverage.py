"""The coverage of behavior trees: recorded while a tree is ticked, merged with other runs, and kept as JSON.

Without coverage, this costs nothing. With coverage, each tick counts each node that is ticked. Halts are counted in
each node's ``stop``, and suspensions in each action leaf's ``suspend``.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Annotated, Any, Final, NamedTuple, Self, TypeAlias

from py_trees.common import Status
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from bt_controller.core.action_leaf import ActionLeaf
from bt_controller.core.node import MAX_CLASSES, Node
from bt_controller.core.subtrees import paths
from bt_controller.coverage.kinds import possible_outcomes, recovers, variant_of
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
from hmrsim.caches import LruCache
from hmrsim.errors import HmrsimError

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour

    from hmrsim_zenoh.client.goal_handle import GoalHandle


_SELF: Final = "{robot}"
_KEPT: Final = 1024
"""The number of trees whose description a process keeps."""


class Described(NamedTuple):
    """The description of a node, derived from the structure of its tree.

    Attributes:
        place: The index of each of its ancestors, and of itself, among the children of its parent.
        path: Its path, as in `NodeCoverage`.
        kind: Its class.
        origin: Its file and line, if it comes from a file.
        possible: Its possible outcomes.
        end: The number after that of its last descendant; nodes are numbered from 0, parents first.
        sends_goals: Whether it is an `ActionLeaf`.
        recovers: Whether it handles failures of its children.
    """

    place: tuple[int, ...]
    path: str
    kind: str
    origin: str
    possible: frozenset[str]
    end: int
    sends_goals: bool
    recovers: bool


Counted: TypeAlias = tuple["Behaviour", Described, NodeCoverage]
"""A node, and what is counted of it."""


def described(root: Behaviour, robot: str | None) -> Iterator[tuple[Behaviour, Described]]:
    """Return the nodes of a tree, parents first; the robot's name in paths is ``{robot}``."""
    nodes, todo = [], [root]
    while todo:
        nodes.append(todo.pop())
        todo += reversed(nodes[-1].children)
    # Each run builds the same trees again, and their descriptions take longer than these keys.
    shape = tuple([(node.__class__, node.name, len(node.children), variant_of(node), _origin(node)) for node in nodes])
    return zip(nodes, _DESCRIPTIONS.get((robot, shape), lambda: [*_descriptions(root, robot)]), strict=True)


_DESCRIPTIONS: Final[LruCache[tuple[str | None, tuple[object, ...]], list[Described]]] = LruCache(_KEPT)


def _descriptions(root: Behaviour, robot: str | None) -> Iterator[Described]:
    possible = possible_outcomes(root)
    own = None if robot is None else re.compile(rf"\b{re.escape(robot)}\b")
    places: dict[Behaviour, tuple[int, ...]] = {root: ()}
    sizes: dict[Behaviour, int] = {}
    _measure(root, sizes)
    for number, (node, path) in enumerate(paths(root)):
        for index, child in enumerate(node.children):
            places[child] = (*places[node], index)
        yield Described(
            places[node],
            path if own is None else own.sub(_SELF, path),
            type(node).__name__,
            _origin(node),
            possible[node],
            number + sizes[node],
            isinstance(node, ActionLeaf),
            recovers(node),
        )


def _origin(node: Any) -> str:
    origin: str = node.origin if _has_origin(node.__class__) else ""
    return origin


@lru_cache(MAX_CLASSES)
def _has_origin(kind: type[Behaviour]) -> bool:
    """Return whether a class is one of XML trees; once for each, as classes of py_trees take a while to say so."""
    return issubclass(kind, Node)


def _measure(node: Behaviour, sizes: dict[Behaviour, int]) -> int:
    """Record the number of nodes of each subtree in *sizes*, and return that of the node."""
    size = sizes[node] = 1 + sum([_measure(child, sizes) for child in node.children])
    return size


@dataclass(eq=False)
class _Seen:
    """A node of the recorded tree.

    Attributes:
        number: Its number, parents before their children.
        about: Its description.
        covered: Its counts.
        leaf: The node, if it sends goals.
        handle: The goal whose end was counted last.
        halted: In which tick it was halted last.
    """

    number: int
    about: Described
    covered: NodeCoverage
    leaf: ActionLeaf[Any, Any, Any] | None
    handle: GoalHandle[Any, Any] | None = None
    halted: int = 0


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
        """Tick the tree once, and count what its nodes do."""
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
            if seen.about.recovers and self._failed:
                self._recovered(seen)
        elif status is Status.FAILURE:
            counts[FAILURE] += 1
            if RECOVERED in seen.about.possible:
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
        for number in [each for each in self._failed if above.number < each < above.about.end]:
            self._failed.discard(number)
            self._by_number[number].covered.counts[RECOVERED] += 1

    def _halted(self, seen: _Seen) -> None:
        if not self._ended:
            seen.covered.counts[CANCELED] += 1
            seen.halted = self._ticks
            # Failures below it were not recovered.
            self._failed.difference_update(range(seen.number, seen.about.end))

    def _of(self, node: Behaviour) -> _Seen:
        if node not in self._seen:
            self._look()
        return self._seen[node]

    def _look(self) -> None:
        """Number the nodes, and listen to those that are new."""
        self._failed.clear()
        self._by_number.clear()
        stop, suspend = self._stop, self._suspend
        for number, (node, about, covered) in enumerate(self._counted()):
            leaf: Any = node if about.sends_goals else None
            seen = _Seen(number, about, covered, leaf)
            self._by_number.append(seen)
            if node not in self._seen:
                # Not closures, which each run would make anew for each node.
                node.stop = partial(stop, node, node.stop)  # type: ignore[method-assign]
                if leaf is not None:
                    leaf.suspend = partial(suspend, leaf, leaf.suspend)
            self._seen[node] = seen

    def _stop(self, node: Behaviour, stop: Callable[[Status], None], new_status: Status = Status.INVALID) -> None:
        runs = node.status is Status.RUNNING
        stop(new_status)
        if runs and new_status is Status.INVALID:
            self._halted(self._seen[node])

    def _suspend(self, leaf: ActionLeaf[Any, Any, Any], suspend: Callable[[], None]) -> None:
        active = leaf.status is Status.RUNNING and leaf.handle is not None and not leaf.handle.done
        suspend()
        if active and not self._ended:
            self._seen[leaf].covered.counts[CANCELED] += 1


_FORMAT: Final = "hmrsim tree coverage 1"


class CoverageError(HmrsimError):
    """A file can't be read, or is not coverage of trees."""


@dataclass
class _Tree:
    """The nodes of a tree by path, and the number of its runs."""

    runs: int = 0
    nodes: dict[str, NodeCoverage] = field(default_factory=dict)

    def node(self, about: Described) -> NodeCoverage:
        """Return the node of a description."""
        mine = NodeCoverage(about.place, about.path, about.kind, about.origin, about.possible)
        known = self.nodes.setdefault(about.path, mine)
        if known is not mine:
            known.merge(mine)
        return known

    def merge(self, other: _Tree) -> None:
        self.runs += other.runs
        for path, node in other.nodes.items():
            self.nodes.setdefault(path, NodeCoverage(node.place, path, node.kind)).merge(node)

    def in_order(self) -> list[NodeCoverage]:
        """Return the nodes, each followed by those below it; trees of several robots may differ."""
        return [self.nodes[path] for path in sorted(self.nodes, key=self._way)]

    def _way(self, path: str) -> tuple[tuple[int, str], ...]:
        """Return the way from the root to a node."""
        above, way = path, []
        while above:
            if above in self.nodes:
                way.append((next(reversed(self.nodes[above].place), 0), above))
            above = above.rpartition("/")[0]
        return tuple(reversed(way))


class TreeCoverage:
    """The coverage of trees by name; empty at first.

    Trees of one name are counted together: those of several robots, and of several runs.
    """

    def __init__(self) -> None:
        self._trees: dict[str, _Tree] = {}

    @property
    def trees(self) -> tuple[str, ...]:
        """The names of the trees, in order."""
        return tuple(sorted(self._trees))

    def runs(self, tree: str) -> int:
        """Return how many trees of a name were run."""
        return self._trees[tree].runs

    def nodes(self, tree: str) -> list[NodeCoverage]:
        """Return the nodes of a tree, parents before their children."""
        return self._trees[tree].in_order()

    def watch(self, name: str, root: Behaviour, *, robot: str | None = None) -> Recorder:
        """Return a recorder that ticks a tree and counts its outcomes here.

        Args:
            name: The tree's name.
            root: The tree, before its first tick.
            robot: The tree's robot, so that the trees of several robots are counted together.
        """
        tree = self._trees.setdefault(name, _Tree())
        tree.runs += 1

        def counted() -> list[Counted]:
            return [(node, about, tree.node(about)) for node, about in described(root, robot)]

        return Recorder(root, counted)

    def merge(self, other: TreeCoverage) -> None:
        """Add another coverage."""
        for name in other.trees:
            self._trees.setdefault(name, _Tree()).merge(other._trees[name])

    def keys(self) -> frozenset[str]:
        """Return the outcomes that have occurred, such as ``TREE/PATH:FAILURE`` or ``TREE/PATH:ABORTED/204``."""
        return frozenset(
            [
                f"{name}/{path}:{outcome}"
                for name, tree in self._trees.items()
                for path, node in tree.nodes.items()
                for outcome, count in node.counts.items()
                if count
            ]
        )

    def to_json(self) -> dict[str, Any]:
        """Return the coverage as JSON values, in an order that depends on the contents alone."""
        return {
            "format": _FORMAT,
            "trees": {
                name: {"runs": self.runs(name), "nodes": [_plain(node) for node in self.nodes(name)]}
                for name in self.trees
            },
        }

    @classmethod
    def from_json(cls, values: Mapping[str, Any] | str | bytes) -> Self:
        """Return the coverage of the values of `to_json`, or of their text.

        Raises:
            CoverageError: The values are not coverage of trees.
        """
        try:
            if isinstance(values, (str, bytes)):
                read = _File.model_validate_json(values)
            else:
                read = _File.model_validate(values)
        except ValidationError as error:
            why = _reason(error)
            raise CoverageError(
                f"no coverage of trees: {why}; expected a file written by --coverage FILE.json"
            ) from None
        found = cls()
        for name, tree in read.trees.items():
            known = found._trees.setdefault(name, _Tree(tree.runs))
            for node in tree.nodes:
                known.nodes[node.path] = NodeCoverage(
                    tuple(node.place),
                    node.path,
                    node.kind,
                    node.origin,
                    frozenset(node.possible),
                    defaultdict(int, node.counts),
                )
        return found


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class _NodeFile(_Part):
    place: list[Annotated[int, Field(ge=0)]]
    path: str
    kind: str
    origin: str = ""
    possible: list[str]
    counts: dict[str, Annotated[int, Field(ge=0)]]


class _TreeFile(_Part):
    runs: Annotated[int, Field(ge=0)]
    nodes: list[_NodeFile]


class _File(_Part):
    format: Annotated[str, Field(pattern=f"^{_FORMAT}$")]
    trees: dict[str, _TreeFile]


def _plain(node: NodeCoverage) -> dict[str, Any]:
    values: dict[str, Any] = {"place": [*node.place], "path": node.path, "kind": node.kind}
    if node.origin:
        values["origin"] = node.origin
    return {**values, "possible": sorted(node.possible), "counts": node.seen}


def _reason(error: ValidationError) -> str:
    """Return the first reason as one line."""
    first = error.errors()[0]
    return f"{'.'.join(map(str, first['loc'])) or 'the file'}: {first['msg']}"
