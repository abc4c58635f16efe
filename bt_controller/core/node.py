"""The nodes of XML trees: py_trees behaviours with ports that keep to BehaviorTree.CPP's rules.

What is different from py_trees:

- **Idle** is INVALID: a node that was never ticked, or was reset by its parent. A node may be ticked again after it
  has ended without having been reset; then its status is what it ended with.
- **Skipped** is INVALID as the outcome of a tick: whoever ticked it goes on as if it weren't there.
- Who ends keeps the statuses of its children until it begins again, so that one can see how they ended.
"""

from __future__ import annotations

import math
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.composites import Composite
from py_trees.decorators import Decorator
from py_trees.ports import PortsMixin

from hmrsim.errors import HmrsimError

if TYPE_CHECKING:
    from collections.abc import Generator, Iterator, Mapping, Sequence

    from bt_controller.core.ports import Places, Port

EACH_PERIOD = -math.inf
"""What `Node.next_tick_time` returns where nobody tells a node when to look again."""


class PortError(HmrsimError):
    """A port has no value, or one of another kind; the text says which, and whose."""


class Node(PortsMixin):
    """What all nodes have: ports, and when they have to be ticked.

    Subclasses say their ports in `INPUTS` and `OUTPUTS`, made by `input_port` and `output_port`.

    Attributes:
        origin: File and line, for messages.
    """

    INPUTS: ClassVar[Mapping[str, Port]] = MappingProxyType({})
    OUTPUTS: ClassVar[Mapping[str, Port]] = MappingProxyType({})

    origin: str = ""

    def __init_subclass__(cls, **kwargs: Any) -> None:
        """Tell py_trees of the ports; keep the class out of its register: we have one of ours."""
        cls.INPUT_PORTS, cls.OUTPUT_PORTS = dict(cls.INPUTS), dict(cls.OUTPUTS)
        super().__init_subclass__(register=False, **kwargs)

    def setup(self, **kwargs: Any) -> None:
        """Remember who knows the places; texts of ports are looked at, so that what is wrong is said at once.

        Args:
            **kwargs: *places*, a `Places`; and what others want.

        Raises:
            PortError: What the file says is not what a port takes.
        """
        super().setup(**kwargs)
        self._places: Places | None = kwargs.get("places")
        for port in self.INPUTS:
            client = self.blackboard_client
            if client.exists(port) and isinstance(client.get(port), str):
                self.read(port)

    def read(self, port: str) -> Any:
        """Return the value of an input port; of one that need not have any and has none, None.

        Raises:
            PortError: It has none, or one of another kind.
        """
        information = self.INPUTS[port]
        client = self.blackboard_client
        value = client.get(port) if client.exists(port) else None
        if value is None:
            if information.required and information.default_value is None:
                raise PortError(f"{self._whose(port)} has no value: nothing has written it so far")
            default = information.default_value
            # A key that the port leads to where the file says nothing is no value.
            return None if isinstance(default, str) and default.startswith("{") else default
        kind = information.kind
        if isinstance(value, str) and kind.type is not str:
            try:
                return kind.read(value, getattr(self, "_places", None))
            except ValueError as error:
                raise PortError(f"{self._whose(port)}: {error}") from None
        if not kind.holds(value):
            raise PortError(f"{self._whose(port)} takes {kind.name}, got {type(value).__name__} {value!r:.80}")
        return value

    def write(self, port: str, value: Any) -> None:
        """Put a value where an output port leads; nowhere if the file says nothing of it."""
        self.blackboard_client.set(port, value)

    def next_tick_time(self) -> float:
        """Return when this node has to be ticked again if nothing happens to its goals or its children.

        Returns:
            Simulated seconds; infinite for never, `EACH_PERIOD` if nobody can tell.
        """
        return math.inf

    def next_ticked(self) -> Sequence[Behaviour]:
        """Return the children that the next tick may look at."""
        return ()

    @property
    def behind(self) -> float:
        """By how many seconds the time of the children is behind this node's, as it stood still for them."""
        return 0.0

    def _whose(self, port: str) -> str:
        where = f" ({self.origin})" if self.origin else ""
        return f"{self.name}{where}: port {port!r}"


class Leaf(Node, Behaviour):
    """A node without children that takes no time, and to which nothing becomes different by itself.

    A subclass of which that is not true says when to look again.
    """


class Condition(Leaf):
    """A node that looks at something: at the blackboard, the time, a topic."""

    def next_tick_time(self) -> float:
        """Return that nobody tells it when that has changed; a subclass may know better."""
        return EACH_PERIOD


class _Parent(Node):
    """How a node with children is ticked."""

    def advance(self) -> Generator[Behaviour, None, Status]:
        """Tick children by ``yield from child.tick()``, and return the node's status; INVALID if it is skipped."""
        raise NotImplementedError

    def next_tick_time(self) -> float:
        """Return that a running node waits for its children, and that one which has ended begins again."""
        return math.inf if self.status is Status.RUNNING else EACH_PERIOD

    def next_ticked(self) -> Sequence[Behaviour]:
        """Return the children that the next tick may look at: by default, those that run."""
        return [child for child in self.children if child.status is Status.RUNNING]

    def tick(self) -> Iterator[Behaviour]:
        """Tick the node."""
        if self.status is not Status.RUNNING:
            self._reset_children()
            self.initialise()
        status = yield from self.advance()
        if status is not Status.RUNNING:
            for child in self.children:
                self.halt(child)
            self.stop(status)
        self.status = status
        yield self

    @staticmethod
    def halt(child: Behaviour) -> None:
        """Interrupt a child that runs; one that has ended keeps its status."""
        if child.status is Status.RUNNING:
            child.stop(Status.INVALID)

    @staticmethod
    def reset(child: Behaviour) -> None:
        """Make a child idle, whatever it was."""
        if child.status is not Status.INVALID:
            child.stop(Status.INVALID)

    def _reset_children(self) -> None:
        for child in self.children:
            self.reset(child)


class Control(_Parent, Composite):
    """A node with any number of children."""

    least = 1
    """How many children there have to be."""
    most = math.inf
    """How many there may be."""


class Decoration(_Parent, Decorator):
    """A node with one child; one that has ended is idle when it is ticked again, as in BehaviorTree.CPP."""

    @property
    def child(self) -> Behaviour:
        """The child."""
        child: Behaviour = self.decorated
        return child

    def update(self) -> Status:
        """Return the status; py_trees' decorators have to have this, ours `advance`."""
        status: Status = self.status
        return status

    def tick_child(self) -> Generator[Behaviour, None, Status]:
        """Tick the child, and return its status; INVALID if it was skipped."""
        if self.child.status is not Status.RUNNING:
            self.reset(self.child)
        yield from self.child.tick()
        status: Status = self.child.status
        return status

    def _reset_children(self) -> None:
        """Leave a child that has ended as it is until it is ticked again."""
