"""The nodes of XML trees: py_trees behaviors with ports and with BehaviorTree.CPP's semantics.

The differences to py_trees:

- **Idle** is INVALID: a node that was never ticked, or was reset by its parent. A node that has ended may be ticked
  again without a reset; at that tick its status is still the final one.
- **Skipped** is INVALID as the result of a tick: the parent continues as if the node did not exist.
- A node that has ended keeps the statuses of its children until it starts again, for displays.
"""

from __future__ import annotations

import math
import re
from collections.abc import Generator, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Final, NamedTuple, TypeAlias

from py_trees.behaviour import Behaviour
from py_trees.blackboard import Blackboard, KeyMetaData
from py_trees.common import Access, Status
from py_trees.composites import Composite
from py_trees.decorators import Decorator
from py_trees.ports import CONST_PREFIX, PortsMixin, decode_const_value

from hmrsim.errors import HmrsimError

if TYPE_CHECKING:
    from py_trees.blackboard import Client

    from bt_controller.core.ports import Places, Port
    from hmrsim_zenoh.client.connection import Condition as TopicCondition

EACH_PERIOD = -math.inf
"""The value of `Node.next_tick_time` for a node that has to be polled."""
MAX_CLASSES: Final = 1024
"""The number of classes of which a cache keeps something: trees may define classes of their own in each run."""

_NO_NAME: Final = re.compile(r"[^A-Za-z0-9_-]")
"""Characters that can't be part of a key."""

Ticks: TypeAlias = "Generator[Behaviour, None, Status]"
"""The ticks of a node's children; the value is the node's status."""


class PortError(HmrsimError):
    """A port has no value, or one of another kind; the text names the port and the node."""


class QuietBehaviour(Behaviour):
    """A behavior without children and without py_trees' debug log, which takes longer than the tick itself."""

    def tick(self) -> Iterator[Behaviour]:
        """Tick the behavior, as py_trees does."""
        if self.status is not Status.RUNNING:
            self.initialise()
        status = self.update()
        if not isinstance(status, Status):
            text = f"A behavior returned an invalid status, setting to INVALID [{status}][{self.name}]"
            self.logger.error(text)
            status = Status.INVALID
        if status is not Status.RUNNING:
            self.stop(status)
        self.status = status
        yield self

    def stop(self, new_status: Status = Status.INVALID) -> None:
        """End the behavior with a status, or interrupt it with INVALID."""
        self.terminate(new_status)
        self.status = new_status


class Connections(NamedTuple):
    """The blackboard keys of a node's ports; all nodes that are made from one element of a file have the same.

    Attributes:
        namespace: The namespace of keys without a slash.
        keys: The key of each port.
        texts: The values in the file, by key.
        read: The keys of input ports that other nodes may write.
        written: The keys of output ports that other nodes may read.
    """

    namespace: str
    keys: Mapping[str, str]
    texts: Mapping[str, str]
    read: Sequence[str]
    written: Sequence[str]

    @classmethod
    def of(
        cls, kind: type[Node], own: str, keys: Mapping[str, str], texts: Mapping[str, str], namespace: str
    ) -> Connections:
        """Return the connections of a node.

        Args:
            kind: Its class.
            own: A name that no other node of the tree has.
            keys: The keys of ports. A port without a key and a text has its own key.
            texts: The texts of ports.
            namespace: The namespace of keys without a slash.
        """
        below = Blackboard.absolute_name(namespace, _NO_NAME.sub("_", own))
        found = {port: Blackboard.absolute_name(namespace, key) for port, key in keys.items()}
        for port in (*kind.INPUTS, *kind.OUTPUTS):
            if port not in found:
                found[port] = f"{below}/{port}__const" if port in texts else f"{below}/{port}__own"
        return cls(
            namespace,
            found,
            {found[port]: text for port, text in texts.items()},
            [found[port] for port in kind.INPUTS if port in keys],
            [found[port] for port in kind.OUTPUTS if port in keys],
        )


class Node(PortsMixin):
    """The base of all nodes: ports, and the time of the next tick.

    Subclasses declare their ports in `INPUTS` and `OUTPUTS`, made by `input_port` and `output_port`.

    Attributes:
        origin: File and line, for messages.
    """

    INPUTS: ClassVar[Mapping[str, Port]] = MappingProxyType({})
    OUTPUTS: ClassVar[Mapping[str, Port]] = MappingProxyType({})

    origin: str = ""

    def __init_subclass__(cls, **kwargs: Any) -> None:
        """Declare the ports to py_trees; keep the class out of its registry, since this package has its own."""
        cls.INPUT_PORTS, cls.OUTPUT_PORTS = dict(cls.INPUTS), dict(cls.OUTPUTS)
        super().__init_subclass__(register=False, **kwargs)

    def __init__(self, *args: Any, behaviour_class_name: str | None = None, **kwargs: Any) -> None:
        """Make the node; its ports are set up later.

        This replaces the constructor of `PortsMixin`, which looks for abstract methods each time that a node is made.
        """
        super(PortsMixin, self).__init__(*args, **kwargs)
        self._blackboard_client: Client | None = None
        self._subtree_namespace: str | None = None
        self._ports_logger: Any = None
        self._behaviour_class_name = behaviour_class_name or type(self).__name__
        self._places: Places | None = None
        self._parsed: dict[str, tuple[str, Any]] = {}

    def setup_ports(
        self,
        port_remappings: Mapping[str, str] | None = None,
        subtree_namespace: str = "/",
        logger: Any = None,
    ) -> None:
        """Connect the ports with the blackboard.

        This replaces the method of `PortsMixin`. It does not log each port, a value in a file stays text that the port
        reads as its kind, and no output has a default.

        Args:
            port_remappings: The key of each port, or its value as py_trees' parser encodes it; a port that is left out
                has its own key.
            subtree_namespace: The namespace of keys without a slash.
            logger: The logger of the node; by default its own.
        """
        self._ports_logger = logger
        keys, texts = dict(port_remappings or {}), {}
        for port, key in [*keys.items()]:
            if CONST_PREFIX in key:
                texts[port] = decode_const_value(keys.pop(port))
        own = f"{self.name}_{self.id}"
        self.connect(Connections.of(type(self), own, keys, texts, subtree_namespace))

    def connect(self, connections: Connections) -> None:
        """Connect the ports with the blackboard in use."""
        self._keys, self._texts = connections.keys, connections.texts
        self._subtree_namespace = connections.namespace
        self._ports_logger = self._ports_logger or self.logger
        # Without py_trees' clients: making them takes longer than the rest of a node.
        Blackboard.storage.update(connections.texts)
        for key in connections.read:
            _known(key).read.add(self.id)
        for key in connections.written:
            _known(key).write.add(self.id)
        if connections.read or connections.written:
            Blackboard.clients[self.id] = self.name

    @property
    def blackboard_client(self) -> Client:
        """The node's ports as a client of py_trees' blackboard, which is made upon first use.

        Raises:
            RuntimeError: The ports have not been set up.
        """
        if self._blackboard_client is None and self._subtree_namespace is not None:
            client = self._blackboard_client = self.attach_blackboard_client(self.name, self._subtree_namespace)
            for ports, access in ((self.INPUTS, Access.READ), (self.OUTPUTS, Access.WRITE)):
                for port, information in ports.items():
                    needed = information.required and not information.has_default
                    client.register_key(key=port, access=access, required=needed, remap_to=self._keys[port])
        return super().blackboard_client

    @property
    def port_texts(self) -> dict[str, str]:
        """The texts of the ports to which the file gives a value, by port."""
        return {port: self._texts[key] for port, key in self._keys.items() if key in self._texts}

    def key_of(self, port: str) -> str:
        """Return the blackboard key of a port."""
        return self._keys[port]

    def entry(self, port: str) -> Any:
        """Return the blackboard entry of a port, which may still be text; None if it has no value."""
        return Blackboard.storage.get(self._keys[port])

    def setup(self, **kwargs: Any) -> None:
        """Remember the places, and check the ports' texts early.

        Args:
            **kwargs: *places*, a `Places`, and the arguments of other behaviors.

        Raises:
            PortError: A port's value in the file is invalid.
        """
        super().setup(**kwargs)
        self._places = kwargs.get("places")
        self._parsed.clear()
        for port in self.INPUTS:
            if isinstance(Blackboard.storage.get(self._keys[port]), str):
                self.read(port)

    def read(self, port: str) -> Any:
        """Return the value of an input port; None if it is optional and has no value.

        Raises:
            PortError: The port has no value, or one of another kind.
        """
        information = self.INPUTS[port]
        value = Blackboard.storage.get(self._keys[port])
        if value is None:
            if information.required and information.default_value is None:
                raise PortError(f"{self._whose(port)} has no value yet")
            default = information.default_value
            # The default key of a port that the file omits does not count as a value.
            return None if isinstance(default, str) and default.startswith("{") else default
        kind = information.kind
        if isinstance(value, str) and kind.type is not str:
            return self._read_text(port, value)
        if not kind.holds(value):
            raise PortError(f"{self._whose(port)} takes {kind.name}, got {type(value).__name__} {value!r:.80}")
        return value

    def write(self, port: str, value: Any) -> None:
        """Write a value to an output port's key; drop it if the file omits the port."""
        if port not in self.OUTPUTS:
            there = ", ".join(self.OUTPUTS) or "none"
            raise ValueError(f"{self.located} has no output port {port!r}; there are {there}")
        Blackboard.storage[self._keys[port]] = value

    def next_tick_time(self) -> float:
        """Return when this node has to be ticked again without an event of its goals or children.

        Returns:
            Simulated seconds; infinite for never, `EACH_PERIOD` if it has to be polled.
        """
        return math.inf

    def awaited(self) -> Sequence[TopicCondition]:
        """Return further conditions for which this node has to be ticked; in lockstep, time stops for them."""
        return ()

    def next_ticked(self) -> Sequence[Behaviour]:
        """Return the children that the next tick may tick."""
        return ()

    @property
    def behind(self) -> float:
        """The seconds for which time stood still for the children, but not for this node."""
        return 0.0

    def is_read(self, port: str) -> bool:
        """Return whether another node reads the values of an output port."""
        known = Blackboard.metadata.get(self._keys[port])
        return known is not None and bool(known.read)

    @property
    def located(self) -> str:
        """The node's name and its place in a file, for messages."""
        return f"{self.name} ({self.origin})" if self.origin else self.name

    def _read_text(self, port: str, text: str) -> Any:
        """Return the value of a text; the same text has the same value until the node is set up again."""
        known = self._parsed.get(port)
        if known is not None and known[0] == text:
            return known[1]
        try:
            value = self.INPUTS[port].kind.read(text, self._places)
        except ValueError as error:
            raise PortError(f"{self._whose(port)}: {error}") from None
        # A reader may change a list.
        if not isinstance(value, list):
            self._parsed[port] = text, value
        return value

    def _whose(self, port: str) -> str:
        return f"{self.located}: port {port!r}"


def _known(key: str) -> KeyMetaData:
    """Return the readers and writers of an entry of the blackboard in use."""
    known = Blackboard.metadata.get(key)
    if known is None:
        known = Blackboard.metadata[key] = KeyMetaData()
    return known


class Leaf(Node, QuietBehaviour):
    """A node without children, which by default takes no time and does not depend on changing state.

    Subclasses that do override `next_tick_time`.
    """


class Condition(Leaf):
    """A node that reads changing state: the blackboard, the time, a topic."""

    def next_tick_time(self) -> float:
        """Return that the node has to be polled; a subclass may be notified of changes."""
        return EACH_PERIOD


class _Parent(Node):
    """A node with children, which it ticks."""

    def advance(self) -> Ticks:
        """Tick the children by ``yield from child.tick()``, and return the node's status; INVALID if it is skipped."""
        raise NotImplementedError

    def next_tick_time(self) -> float:
        """Return never for a RUNNING node, which waits for its children; a node that has ended is polled."""
        return math.inf if self.status is Status.RUNNING else EACH_PERIOD

    def next_ticked(self) -> Sequence[Behaviour]:
        """Return the children that the next tick may tick: by default, the running ones."""
        return [child for child in self.children if child.status is Status.RUNNING]

    def tick(self) -> Iterator[Behaviour]:
        """Tick the node, and halt its children when it ends."""
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
        """Make a child idle, whatever its status."""
        if child.status is not Status.INVALID:
            child.stop(Status.INVALID)

    def _reset_children(self) -> None:
        for child in self.children:
            self.reset(child)


class Control(_Parent, Composite):
    """A node with any number of children."""

    least = 1
    """The least number of children."""
    most = math.inf
    """The largest number of children."""


class Decoration(_Parent, Decorator):
    """A node with one child; one that has ended is idle when it is ticked again, as in BehaviorTree.CPP."""

    @property
    def child(self) -> Behaviour:
        """The only child of the decorator."""
        child: Behaviour = self.decorated
        return child

    def update(self) -> Status:
        """Return the status: py_trees requires this method, but the nodes of this package override `advance`."""
        status: Status = self.status
        return status

    def tick_child(self) -> Ticks:
        """Tick the child, and return its status; INVALID if it was skipped."""
        if self.child.status is not Status.RUNNING:
            self.reset(self.child)
        yield from self.child.tick()
        status: Status = self.child.status
        return status

    def _reset_children(self) -> None:
        """Keep the status of a child that has ended until it is ticked again."""
