"""The coverage of behavior trees: counts of what happened to each node, which can be merged and kept as JSON."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any, Final, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from bt_controller.coverage.node_coverage import RECOVERED, NodeCoverage
from bt_controller.coverage.recording import Recorder, watched
from hmrsim.errors import HmrsimError

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour

_FORMAT: Final = "hmrsim tree coverage 1"


class CoverageError(HmrsimError):
    """A text is no coverage of trees, or a file can't be read; the text says which."""


@dataclass
class _Tree:
    """The nodes of a tree by path, and how many trees of the name were run."""

    runs: int = 0
    nodes: dict[str, NodeCoverage] = field(default_factory=dict)

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
        """Return what ticks a tree and counts here what happens.

        Args:
            name: The tree's name.
            root: The tree, before its first tick.
            robot: The robot whose tree it is, so that those of several robots are counted together.
        """
        tree = self._trees.setdefault(name, _Tree())
        tree.runs += 1

        def counted() -> list[tuple[Behaviour, bool, NodeCoverage]]:
            found = []
            for node, mine in watched(root, robot):
                known = tree.nodes.setdefault(mine.path, mine)
                if known is not mine:
                    known.merge(mine)
                found.append((node, RECOVERED in mine.possible, known))
            return found

        return Recorder(root, counted)

    def merge(self, other: TreeCoverage) -> None:
        """Add another coverage."""
        for name in other.trees:
            self._trees.setdefault(name, _Tree()).merge(other._trees[name])

    def keys(self) -> frozenset[str]:
        """Return what happened, without how often: texts such as ``TREE/PATH:FAILURE`` or ``TREE/PATH:ABORTED/204``."""
        return frozenset(
            f"{name}/{path}:{outcome}"
            for name, tree in self._trees.items()
            for path, node in tree.nodes.items()
            for outcome, count in node.counts.items()
            if count
        )

    def to_json(self) -> dict[str, Any]:
        """Return the coverage as JSON values, in an order that depends on nothing but the contents."""
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
            CoverageError: They are no coverage of trees.
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
                    tuple(node.place), node.path, node.kind, node.origin, frozenset(node.possible), Counter(node.counts)
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
