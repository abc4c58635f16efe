"""What the network is told of us: nodes and endpoints, in the background, as that takes seconds for many robots."""

from __future__ import annotations

import itertools
import logging
import threading
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, Final

import zenoh

from hmrsim_zenoh.ros2 import keys
from hmrsim_zenoh.ros2.keys import Kind
from hmrsim_zenoh.ros2.wires import RmwZenoh

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

    from hmrsim_zenoh.ros2.keys import Endpoint, Node
    from hmrsim_zenoh.ros2.publishing.endpoints import Owned, Part
    from hmrsim_zenoh.ros2.publishing.publishers import Outlets
    from hmrsim_zenoh.ros2.wires import Wire

_log = logging.getLogger(__name__)

_JOIN_SECONDS: Final = 1.0
"""Wall seconds for the declaration that is being made at the end."""


@dataclass
class _Declared:
    """A token that is declared.

    Attributes:
        id: The number that it has in the session.
        token: What Zenoh has of it.
        used: How many need it.
    """

    id: int
    token: Any
    used: int = 1


class Declarations:
    """Tells of what is wanted and of nothing else, in a thread of its own.

    Args:
        session: Where to declare.
        wire: How, and whether there are tokens at all.
        endpoints_of: Gives the endpoints of a part.
        outlets: What is opened when a publisher is declared, before its token is.
    """

    def __init__(
        self, session: zenoh.Session, wire: Wire, endpoints_of: Callable[[Part], Iterable[Owned]], outlets: Outlets
    ) -> None:
        self._session = session
        self._liveliness = session.liveliness()
        self._session_id = str(session.info.zid())
        self._domain = wire.domain if isinstance(wire, RmwZenoh) else None
        self._endpoints_of = endpoints_of
        self._outlets = outlets
        self._ids = itertools.count()
        self._changed = threading.Condition()
        self._wanted: Sequence[Part] | None = None
        self._closed = False
        self._thread: threading.Thread | None = None
        # All nodes of a robot have one number: Zenoh compares a token with all that branch off where it does, and ROS
        # tells nodes of one session apart by their names, too.
        self._numbers: dict[str, int] = {}
        self._nodes: dict[Node, _Declared] = {}
        self._parts: dict[Part, list[tuple[Owned, _Declared | None]]] = {}

    def want(self, parts: Sequence[Part]) -> None:
        """Have these parts declared in this order, and no others; returns at once."""
        with self._changed:
            self._wanted = parts
            self._changed.notify()
            if self._thread is None and not self._closed:
                self._thread = threading.Thread(target=self._run, name="hmrsim-ros2-tokens", daemon=True)
                self._thread.start()

    def close(self) -> None:
        """Declare nothing more; what is declared goes with the session, which must not be closed before.

        Returns once the declaration that is being made is done, after `_JOIN_SECONDS` at the latest: Zenoh's close and
        a declaration at the same time can wait for each other, for 10 s or more.
        """
        with self._changed:
            self._closed = True
            self._changed.notify()
        if self._thread is not None:
            self._thread.join(_JOIN_SECONDS)

    def _run(self) -> None:
        try:
            while not self._closed:
                self._follow(self._next())
        except zenoh.ZError as error:
            _log.debug("the session was closed: %s", error)

    def _next(self) -> Sequence[Part]:
        with self._changed:
            self._changed.wait_for(lambda: self._closed or self._wanted is not None)
            wanted, self._wanted = self._wanted or (), None
        return wanted

    def _follow(self, wanted: Sequence[Part]) -> None:
        """Declare what is wanted unless something else is by now."""
        still = set(wanted)
        for part in [part for part in self._parts if part not in still]:
            if self._closed:
                return
            self._undeclare(part)
        for part in wanted:
            if self._wanted is not None:
                return
            if part not in self._parts:
                self._declare(part)

    def _declare(self, part: Part) -> None:
        declared = self._parts[part] = []
        for owned in self._endpoints_of(part):
            if self._closed:
                return
            with self._going_on("ROS will not hear of %s: %s", owned):
                declared.append((owned, self._declared(owned)))

    @contextmanager
    def _going_on(self, what: str, owned: Owned) -> Iterator[None]:
        """Say what fails, and go on with the rest unless the session was closed."""
        try:
            yield
        except zenoh.ZError as error:
            if self._session.is_closed():
                raise
            _log.warning(what, owned.endpoint.name, error)

    def _declared(self, owned: Owned) -> _Declared | None:
        endpoint = owned.endpoint
        if self._domain is None:
            self._open(endpoint, None)
            return None
        ids = self._node(self._domain, owned.node), next(self._ids)
        token = keys.endpoint_token(self._domain, self._session_id, ids, owned.node, endpoint)
        with ExitStack() as undoing:
            undoing.callback(self._release, owned.node)
            self._open(endpoint, keys.gid(token))
            undoing.callback(self._shut, endpoint)
            declared = _Declared(ids[1], self._liveliness.declare_token(token))
            undoing.pop_all()
        return declared

    def _open(self, endpoint: Endpoint, gid: bytes | None) -> None:
        if endpoint.kind is Kind.PUBLISHER:
            self._outlets.open(endpoint, gid)

    def _shut(self, endpoint: Endpoint) -> None:
        if endpoint.kind is Kind.PUBLISHER:
            self._outlets.shut(endpoint)

    def _node(self, domain: int, node: Node) -> int:
        """Return the id of a node that is needed once more."""
        known = self._nodes.get(node)
        if known is None:
            if node.namespace not in self._numbers:
                self._numbers[node.namespace] = next(self._ids)
            number = self._numbers[node.namespace]
            token = keys.node_token(domain, self._session_id, number, node)
            known = self._nodes[node] = _Declared(number, self._liveliness.declare_token(token), used=0)
        known.used += 1
        return known.id

    def _undeclare(self, part: Part) -> None:
        for owned, declared in self._parts.pop(part):
            undoing: list[Callable[[], None]] = [partial(self._shut, owned.endpoint)]
            if declared is not None:
                undoing = [declared.token.undeclare, *undoing, partial(self._release, owned.node)]
            for undo in undoing:
                with self._going_on("ROS may still hear of %s: %s", owned):
                    undo()

    def _release(self, node: Node) -> None:
        known = self._nodes[node]
        known.used -= 1
        if not known.used:
            del self._nodes[node]
            known.token.undeclare()
