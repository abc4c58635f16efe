"""Trees in the wire format of BehaviorTree.CPP 4, for Groot2 and other programs that show running trees.

The format is that of BehaviorTree.CPP's ``groot2_protocol.h``: requests and replies over ZeroMQ (REQ and REP). The
first frame of a request has 6 bytes: protocol (2), type, and a 4-byte id. A reply repeats them, followed by 16 bytes
that identify the tree, and has its content in a second frame.
"""

from __future__ import annotations

import struct
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING, Final, Self
from uuid import UUID, uuid5
from xml.etree.ElementTree import Element, SubElement, tostring

from py_trees.common import Status

from hmrsim_zenoh.errors import BadOptions

if TYPE_CHECKING:
    from bt_controller.running.mission import Mission
    from bt_controller.running.snapshot import Node

try:
    import msgpack
    import zmq
except ImportError:
    raise BadOptions("--groot2 needs packages that are not installed; pip install 'hmrsim[groot2]'") from None

PORT: Final = 1667
"""The port to which Groot2 connects by default."""

_PROTOCOL: Final = 2
_HEADER: Final = struct.Struct("<BBI")
_STATUS: Final = struct.Struct("<HB")
"""The number of a node, and its status."""
_TRANSITION: Final = struct.Struct("<6sHB")
"""Microseconds since the recording began, the number of a node, and its status."""
_STATUSES: Final = {Status.INVALID: 0, Status.RUNNING: 1, Status.SUCCESS: 2, Status.FAILURE: 3}
_NAMESPACE: Final = UUID("6ba7b812-9dad-11d1-80b4-00c04fd430c8")
_MAX_TRANSITIONS: Final = 1000
"""Transitions of a recording to keep, as BehaviorTree.CPP does."""
_LOOK_MS: Final = 100
_TAGS: Final = {"Selector": "Fallback"}
"""The names of BehaviorTree.CPP for nodes of py_trees."""
_SUBTREE: Final = "SubTree"
_MAX_PORT: Final = 65_535


class Groot2Publishers:
    """Servers of running trees: one for each mission, from a port on; a context manager.

    Each server takes a port and leaves the next one free, as BehaviorTree.CPP publishes breakpoints there.

    Raises:
        BadOptions: A port is taken, or does not exist.
    """

    def __init__(self, missions: Sequence[Mission], port: int = PORT) -> None:
        last = port + 2 * (len(missions) - 1)
        if not 1 <= port <= last <= _MAX_PORT:
            asked = f"{port} is not a port" if port == last else f"the trees need the ports {port} to {last}"
            raise BadOptions(f"--groot2: {asked}; ports are numbers from 1 to {_MAX_PORT}")
        self._servers = {mission.robot: _Server(mission, port + 2 * i) for i, mission in enumerate(missions)}
        self._ending = ExitStack()

    def __enter__(self) -> Self:
        """Start serving the trees to Groot2."""
        with ExitStack() as started:
            for server in self._servers.values():
                started.enter_context(server.serving())
            self._ending = started.pop_all()
        return self

    def __exit__(self, *_error: object) -> None:
        """Stop the servers."""
        self._ending.close()

    @property
    def ports(self) -> dict[str, int]:
        """The port of each mission's tree, by its robot."""
        return {robot: server.port for robot, server in self._servers.items()}

    def ticked(self, mission: Mission, _now: float | None) -> None:
        """Record the transitions of a tick, if a client has asked for that."""
        self._servers[mission.robot].note_transitions()


class _Server:
    """Answers requests about one tree, in a thread."""

    def __init__(self, mission: Mission, port: int) -> None:
        self.port = port
        self._mission = mission
        self._recording = _Recording()
        # Clients read the tree again when this changes.
        self._tree_id = uuid5(_NAMESPACE, tree_xml(self._nodes()).decode()).bytes

    @contextmanager
    def serving(self) -> Iterator[None]:
        """Answer requests during the context.

        Raises:
            BadOptions: The port is taken.
        """
        stopping = threading.Event()
        with zmq.Context() as context, context.socket(zmq.REP) as socket:
            socket.setsockopt(zmq.LINGER, 0)
            try:
                socket.bind(f"tcp://127.0.0.1:{self.port}")
            except zmq.ZMQError as error:
                raise BadOptions(f"--groot2: port {self.port} can't be served: {error}; name another") from None
            name = f"groot2 {self._mission.robot}"
            thread = threading.Thread(target=self._answer_all, args=(socket, stopping), name=name, daemon=True)
            thread.start()
            try:
                yield
            finally:
                stopping.set()
                thread.join()

    def note_transitions(self) -> None:
        """Record which nodes have changed, while a recording runs."""
        if self._recording.running:
            self._recording.note(self._nodes())

    def _nodes(self) -> Sequence[Node]:
        return self._mission.snapshot(None).nodes

    def _answer_all(self, socket: zmq.Socket[bytes], stopping: threading.Event) -> None:
        while not stopping.is_set():
            if socket.poll(_LOOK_MS):
                socket.send_multipart(self._answer(socket.recv_multipart()))

    def _answer(self, request: Sequence[bytes]) -> Sequence[bytes]:
        """Return the frames of a reply; those of an error for a malformed request."""
        if len(request[0]) != _HEADER.size:
            return [b"error", b"wrong request header"]
        _, kind, number = _HEADER.unpack(request[0])
        header = _HEADER.pack(_PROTOCOL, kind, number) + self._tree_id
        argument = request[1].decode("utf-8", "replace") if len(request) > 1 else ""
        try:
            content = self._content(chr(kind), argument)
        except (ValueError, OverflowError) as error:
            return [b"error", str(error).encode()]
        return [header] if content is None else [header, content]

    def _content(self, kind: str, argument: str) -> bytes | None:
        """Return the content of a reply to a type of request; None if the reply has none.

        Raises:
            ValueError: The request is not supported.
            OverflowError: A number on the blackboard has more than 64 bits, which MessagePack can't hold.
        """
        answers: dict[str, Callable[[], bytes | None]] = {
            "T": lambda: tree_xml(self._nodes()),
            "S": lambda: b"".join(_STATUS.pack(i, _STATUSES[node.status]) for i, node in enumerate(self._nodes(), 1)),
            "B": lambda: self._blackboards(argument.split(";")),
            "r": lambda: self._recording.toggle(self._nodes(), start=argument == "start"),
            "t": self._recording.take,
            "D": lambda: b"[]",  # there are no breakpoints
            "A": lambda: None,
            "X": lambda: None,
        }
        if kind not in answers:
            raise ValueError("hmrsim supports no breakpoints" if kind in "IRU" else "Request not recognized")
        return answers[kind]()

    def _blackboards(self, names: Sequence[str]) -> bytes:
        """Return the robot's blackboard for each name of a subtree."""
        entries = dict(self._mission.snapshot(None, blackboard=True).blackboard or {})
        return bytes(msgpack.packb({name: entries for name in names if name}))


class _Recording:
    """The last transitions of nodes, while a client records them."""

    def __init__(self) -> None:
        self.running = False
        self._lock = threading.Lock()
        self._began = 0.0
        self._statuses: list[Status] = []
        self._transitions: deque[bytes] = deque(maxlen=_MAX_TRANSITIONS)

    def toggle(self, nodes: Sequence[Node], *, start: bool) -> bytes | None:
        """Start a recording, and return the wall time in microseconds as text; or stop it."""
        with self._lock:
            self.running = start
            if not start:
                return None
            self._began = time.monotonic()
            self._statuses = [node.status for node in nodes]
            self._transitions.clear()
            return str(time.time_ns() // 1000).encode()

    def note(self, nodes: Sequence[Node]) -> None:
        """Record which nodes have another status than before; a behavior may have changed its children."""
        with self._lock:
            elapsed = int(1e6 * (time.monotonic() - self._began)).to_bytes(6, "little")
            statuses = [node.status for node in nodes]
            for i, (before, status) in enumerate(zip(self._statuses, statuses, strict=False), 1):
                if status is not before:
                    self._transitions.append(_TRANSITION.pack(elapsed, i, _STATUSES[status]))
            self._statuses = statuses

    def take(self) -> bytes:
        """Return the transitions since the last call."""
        with self._lock:
            taken = b"".join(self._transitions)
            self._transitions.clear()
            return taken


def tree_xml(nodes: Sequence[Node]) -> bytes:
    """Return a tree in the XML of BehaviorTree.CPP, with the numbers of its nodes from 1 in ``_uid``.

    A subtree is an element without children; its content is a separate ``BehaviorTree``, in the order of the elements.
    """
    root = Element("root", BTCPP_format="4", main_tree_to_execute=nodes[0].name)
    models: dict[str, str] = {}
    # By depth: the element to which a node is added, and the beginning of its path.
    above = [(SubElement(root, "BehaviorTree", ID=nodes[0].name, _fullpath=""), "")]
    for number, node in enumerate(nodes, 1):
        del above[node.depth + 1 :]
        parent, path = above[-1]
        tag, full = _TAGS.get(node.kind, node.kind), f"{path}{node.name}::{number}"
        element = SubElement(parent, tag, name=node.name, _uid=str(number), _fullpath=full)
        if node.kind == _SUBTREE:
            element.set("ID", node.name)
            element, path = SubElement(root, "BehaviorTree", ID=node.name, _fullpath=full), f"{full}/"
        else:
            models[tag] = node.category
        above.append((element, path))
    described = SubElement(root, "TreeNodesModel")
    for tag, category in sorted(models.items()):
        SubElement(described, category, ID=tag)
    return tostring(root)
