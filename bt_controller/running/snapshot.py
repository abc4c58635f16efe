"""A tree's state at an instant, as plain values and as text."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from py_trees.common import Status
from py_trees.composites import Composite, Parallel, Selector, Sequence
from py_trees.decorators import Decorator
from pydantic_core import PydanticSerializationError, to_jsonable_python

from bt_controller.core.blackboards import GENERATED
from bt_controller.core.node import MAX_CLASSES
from bt_controller.core.node import Node as XmlNode
from hmrsim.diagnostics import shortened

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour

    from bt_controller.coverage import NodeCoverage

_INDENT: Final = 4

UNICODE: Final = {Status.SUCCESS: "✓", Status.FAILURE: "✕", Status.RUNNING: "*", Status.INVALID: "-"}
"""py_trees' symbols of the statuses."""
ASCII: Final = {Status.SUCCESS: "o", Status.FAILURE: "x", Status.RUNNING: "*", Status.INVALID: "-"}
"""py_trees' symbols of the statuses in ASCII."""

_OF_TAGS: Final = {
    "Sequence": "{-}",
    "SequenceWithMemory": "{-}",
    "AsyncSequence": "{-}",
    "PersistentSequence": "{-}",
    "ReactiveSequence": "[-]",
    "PipelineSequence": "[-]",
    "Fallback": "{o}",
    "AsyncFallback": "{o}",
    "ReactiveFallback": "[o]",
    "Parallel": "/_/",
    "ParallelAll": "/_/",
}
"""The symbols of XML trees' controls that correspond to py_trees' composites."""

_OTHER_CONTROL: Final = "{*}"
_DECORATOR: Final = "-^-"
_LEAF: Final = "-->"
_CATEGORIES: Final = {_LEAF: "Action", _DECORATOR: "Decorator"}


class NodeCounts(NamedTuple):
    """The counts of a node, in all trees with this node.

    Attributes:
        counts: How often each outcome was seen, without RUNNING.
        never: The possible events that never happened.
    """

    counts: tuple[tuple[str, int], ...]
    never: tuple[str, ...]


class Node(NamedTuple):
    """A behavior in a snapshot of its tree.

    Attributes:
        depth: 0 for the root.
        symbol: py_trees' symbol for its kind, such as ``{-}`` for a sequence with memory.
        message: Its feedback message; empty while it is not active.
        origin: File and line, if it comes from a file.
        coverage: Its counts so far, if there are any.
        ports: The values that the file gives to its ports, if they are asked for.
    """

    depth: int
    symbol: str
    kind: str
    name: str
    status: Status
    message: str
    origin: str = ""
    coverage: NodeCounts | None = None
    ports: str = ""

    @property
    def category(self) -> str:
        """Its category in BehaviorTree.CPP: ``Action``, ``Decorator`` or ``Control``."""
        return _CATEGORIES.get(self.symbol, "Control")

    @property
    def words(self) -> str:
        """Its name and feedback message."""
        return f"{self.name}: {self.message}" if self.message else self.name

    def line(self, symbols: Mapping[Status, str] = UNICODE, *, status: bool = True) -> str:
        """Return the behavior as a line of py_trees' text trees."""
        text = f"{' ' * _INDENT * self.depth}{self.symbol} {self.name}"
        if status:
            text += f" [{symbols[self.status]}]"
        return f"{text} -- {self.message}" if self.message else text

    def to_json(self) -> dict[str, Any]:
        """Return the behavior as JSON values."""
        values = {**self._asdict(), "status": self.status.value}
        if not self.origin:
            del values["origin"]
        if not self.ports:
            del values["ports"]
        if self.coverage is None:
            del values["coverage"]
        else:
            values["coverage"] = {"counts": dict(self.coverage.counts), "never": list(self.coverage.never)}
        return values


@dataclass(frozen=True)
class Snapshot:
    """The tree of one robot after a tick.

    Attributes:
        sim_time: Simulated seconds; None before the first clock message.
        tick: The number of the tick, from 1.
        nodes: The behaviors, parents before their children.
        ended: Whether the tree will not be ticked again.
        blackboard: The entries of its blackboard as JSON values; None if not requested.
    """

    robot: str
    sim_time: float | None
    tick: int
    nodes: tuple[Node, ...]
    ended: bool = False
    blackboard: Mapping[str, Any] | None = None

    @property
    def title(self) -> str:
        """The robot and the time."""
        return self.robot if self.sim_time is None else f"{self.robot} at {self.sim_time:.3f} s"

    @property
    def status(self) -> Status:
        """The status of the tree's root."""
        return self.nodes[0].status

    def differs(self, other: Snapshot | None) -> bool:
        """Return whether the snapshot differs from another one by more than the time."""
        if other is None:
            return True
        return (self.nodes, self.ended, self.blackboard) != (other.nodes, other.ended, other.blackboard)

    def to_json(self) -> dict[str, Any]:
        """Return the snapshot as JSON values."""
        values = {
            "robot": self.robot,
            "sim_time": self.sim_time,
            "tick": self.tick,
            "status": self.status.value,
            "ended": self.ended,
            "nodes": [node.to_json() for node in self.nodes],
        }
        return values if self.blackboard is None else {**values, "blackboard": dict(self.blackboard)}


def nodes_of(root: Behaviour, covered: Callable[[Behaviour], NodeCoverage] | None = None) -> tuple[Node, ...]:
    """Return the behaviors of a tree as they are now, with what was counted of each, if that is given."""
    found: list[Node] = []
    _add(root, 0, found, covered)
    return tuple(found)


def nodes_with_ports(root: Behaviour) -> tuple[Node, ...]:
    """Return the behaviors of a tree as they are now, with the values of their ports."""
    nodes = zip(nodes_of(root), _parents_first(root), strict=True)
    return tuple(node._replace(ports=_ports(behavior)) for node, behavior in nodes)


def _parents_first(root: Behaviour) -> Iterator[Behaviour]:
    yield root
    for child in root.children:
        yield from _parents_first(child)


def _ports(behavior: Behaviour) -> str:
    texts = behavior.port_texts.items() if isinstance(behavior, XmlNode) else ()
    return ", ".join(f"{port}: {shortened(_one_line(text))}" for port, text in texts)


def reasons(nodes: tuple[Node, ...]) -> tuple[Node, ...]:
    """Return the behaviors that made a tree fail: the deepest ones whose ancestors have all failed.

    A decorator that fails although its child has not is a reason itself.
    """
    # The deepest level up to which all behaviors above the next one have failed.
    failed = -1
    found: list[Node] = []
    for node in nodes:
        failed = min(failed, node.depth - 1)
        if node.status is Status.FAILURE and failed == node.depth - 1:
            if found and found[-1].depth == node.depth - 1:
                found.pop()
            found.append(node)
            failed = node.depth
    return tuple(found)


def tip(nodes: tuple[Node, ...]) -> Node:
    """Return the current behavior of a tree: the last that is RUNNING or has failed; else the root."""
    if failed := reasons(nodes):
        return failed[-1]
    running = [node for node in nodes if node.status is Status.RUNNING]
    return running[-1] if running else nodes[0]


def _counts(covered: NodeCoverage) -> NodeCounts:
    return NodeCounts(tuple(covered.ends.items()), tuple(covered.never))


def _add(node: Behaviour, depth: int, found: list[Node], covered: Callable[[Behaviour], NodeCoverage] | None) -> None:
    kind = type(node)
    symbol, without_memory = _symbols(kind)
    active = node.status is not Status.INVALID
    found.append(
        Node(
            depth=depth,
            symbol=symbol if getattr(node, "memory", True) else without_memory,
            kind=kind.__name__,
            name=_one_line(node.name),
            status=node.status,
            # py_trees leaves the last message on a behavior that it has reset.
            message=_one_line(node.feedback_message) if active else "",
            origin=node.origin if isinstance(node, XmlNode) else "",
            coverage=None if covered is None else _counts(covered(node)),
        )
    )
    for child in node.children:
        _add(child, depth + 1, found, covered)


@lru_cache(MAX_CLASSES)
def _symbols(kind: type[Behaviour]) -> tuple[str, str]:
    """Return the symbol of a kind, and that of one without memory."""
    if issubclass(kind, Decorator):
        return _DECORATOR, _DECORATOR
    if not issubclass(kind, Composite):
        return _LEAF, _LEAF
    if issubclass(kind, Parallel):
        return "/_/", "/_/"
    if issubclass(kind, Sequence):
        return "{-}", "[-]"
    if issubclass(kind, Selector):
        return "{o}", "[o]"
    symbol = _OF_TAGS.get(kind.__name__, _OTHER_CONTROL)
    return symbol, symbol


def _one_line(text: str) -> str:
    """Return a foreign text as one printable line."""
    return text if text.isprintable() else "".join(letter if letter.isprintable() else " " for letter in text)


def board_values(storage: Mapping[str, Any]) -> dict[str, Any]:
    """Return the user's entries of a blackboard, ordered by key; values without a JSON form are left out."""
    return dict(_json_entries(storage))


def _json_entries(storage: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    for key in sorted(storage):
        if not GENERATED.search(key):
            try:
                yield key.removeprefix("/"), to_jsonable_python(storage[key], inf_nan_mode="null")
            except (PydanticSerializationError, ValueError):
                # Of a kind that is unknown there, or within itself.
                continue
