"""What a tree looks like at an instant, as plain values and as text."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from py_trees.common import Status
from py_trees.composites import Parallel, Selector, Sequence
from py_trees.decorators import Decorator

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from py_trees.behaviour import Behaviour

_INDENT: Final = 4

UNICODE: Final = {Status.SUCCESS: "✓", Status.FAILURE: "✕", Status.RUNNING: "*", Status.INVALID: "-"}
"""How py_trees draws a status."""
ASCII: Final = {Status.SUCCESS: "o", Status.FAILURE: "x", Status.RUNNING: "*", Status.INVALID: "-"}
"""How it does where there is no Unicode."""


@dataclass(frozen=True)
class Node:
    """One behaviour.

    Attributes:
        depth: 0 for the root.
        symbol: py_trees' symbol for its kind, such as ``{-}`` for a sequence with memory.
        kind: Its class.
        name: Its name.
        status: Its status.
        message: What it has to say; nothing where it is not active.
    """

    depth: int
    symbol: str
    kind: str
    name: str
    status: Status
    message: str

    def line(self, symbols: Mapping[Status, str] = UNICODE, *, status: bool = True) -> str:
        """Return the behaviour as a line of py_trees' text trees."""
        text = f"{' ' * _INDENT * self.depth}{self.symbol} {self.name}"
        if status:
            text += f" [{symbols[self.status]}]"
        return f"{text} -- {self.message}" if self.message else text


@dataclass(frozen=True)
class Snapshot:
    """The tree of one robot after a tick.

    Attributes:
        robot: Whose tree.
        sim_time: Simulated seconds; None while no clock was heard.
        tick: Which tick it was, from 1.
        nodes: The behaviours, parents before their children.
    """

    robot: str
    sim_time: float | None
    tick: int
    nodes: tuple[Node, ...]

    @property
    def title(self) -> str:
        """Whose tree it is, and when."""
        return self.robot if self.sim_time is None else f"{self.robot} at {self.sim_time:.3f} s"

    def to_json(self) -> dict[str, Any]:
        """Return the snapshot as JSON has it."""
        nodes = [{**vars(node), "status": node.status.value} for node in self.nodes]
        return {
            "robot": self.robot,
            "sim_time": self.sim_time,
            "tick": self.tick,
            "status": self.nodes[0].status.value,
            "nodes": nodes,
        }


def nodes_of(root: Behaviour) -> tuple[Node, ...]:
    """Return the behaviours of a tree as they are now."""
    return tuple(_walk(root, 0))


def _walk(node: Behaviour, depth: int) -> Iterator[Node]:
    active = node.status is not Status.INVALID
    yield Node(
        depth=depth,
        symbol=_symbol(node),
        kind=type(node).__name__,
        name=_one_line(node.name),
        status=node.status,
        # py_trees leaves the last message on a behaviour that it has reset.
        message=_one_line(node.feedback_message) if active else "",
    )
    for child in node.children:
        yield from _walk(child, depth + 1)


def _symbol(node: Behaviour) -> str:
    if isinstance(node, Parallel):
        return "/_/"
    if isinstance(node, Decorator):
        return "-^-"
    if isinstance(node, Sequence):
        return "{-}" if node.memory else "[-]"
    if isinstance(node, Selector):
        return "{o}" if node.memory else "[o]"
    return "-->"


def _one_line(text: str) -> str:
    """Return a text that comes from elsewhere as something that can't garble a terminal."""
    return text if text.isprintable() else "".join(letter if letter.isprintable() else " " for letter in text)
