"""Declaration of nodes and endpoints in a background thread, as it takes seconds for many robots.

Zenoh compares each token with all others that match ``@ros2_lv/<domain>/**``, which every ROS session watches, so
tokens cost quadratic time, in the simulator and in its clients. A large fleet therefore has only some standing tokens.
The others are declared on request: when a client declares its own token for one, before it waits for a server.
"""

from __future__ import annotations

import itertools
import logging
import threading
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence, Set
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, Final

import zenoh

from hmrsim_zenoh.ros2 import keys
from hmrsim_zenoh.ros2.keys import Kind
from hmrsim_zenoh.ros2.wires import RmwZenoh

if TYPE_CHECKING:
    from hmrsim_zenoh.ros2.keys import Endpoint, Node
    from hmrsim_zenoh.ros2.publishing.endpoints import Owned, Part
    from hmrsim_zenoh.ros2.publishing.publishers import Publishers
    from hmrsim_zenoh.ros2.wires import Wire

_log = logging.getLogger(__name__)

_NOT_DECLARED: Final = "%s could not be declared to ROS: %s"
_NOT_UNDECLARED: Final = "%s could not be undeclared, and ROS may still see it: %s"
_JOIN_SECONDS: Final = 1.0
"""Wall seconds to wait at the end for the declaration in progress."""
_SHARE: Final = 32
"""The number of robots whose nodes share a number: about as many as there are numbers in a fleet of a thousand."""


@dataclass
class _Declared:
    """A declared liveliness token, with its id and the number of its uses."""

    id: int
    token: Any
    uses: int = 1


class Declarations:
    """Declares the standing parts, and others on request, in its own thread.

    Args:
        wire: The ROS 2 wire, which may have no tokens.
        endpoints_of: Returns the endpoints of a part.
        publishers: The publishers; each is opened before its token is declared.
    """

    def __init__(
        self,
        session: zenoh.Session,
        wire: Wire,
        endpoints_of: Callable[[Part], Iterable[Owned]],
        publishers: Publishers,
    ) -> None:
        self._liveliness = session.liveliness()
        self._session_id = str(session.info.zid())
        self._has_tokens = wire.has_types
        self._domain = wire.domain if isinstance(wire, RmwZenoh) else 0
        self._endpoints_of = endpoints_of
        self._publishers = publishers
        self._ids = itertools.count()
        self._changed = threading.Condition()
        self._wanted: tuple[Sequence[Part], int] | None = None
        self._requested: dict[Part, None] = {}
        self._existing: Set[Part] = frozenset()
        self._closed = False
        self._thread: threading.Thread | None = None
        # All nodes of `_SHARE` robots share one number: Zenoh compares a token with all tokens that branch off at the
        # same chunk, and ROS distinguishes the nodes of one session by their names, too.
        self._numbers: dict[str, int] = {}
        self._named = self._number = 0
        self._nodes_of_namespace: Counter[str] = Counter()
        self._nodes: dict[Node, _Declared] = {}
        self._parts: dict[Part, list[tuple[Owned, _Declared | None]]] = {}
        # The nodes that a part declares in addition to those of its endpoints.
        self._nodes_of_parts: dict[Part, list[Node]] = {}

    def want(self, parts: Sequence[Part], standing: int | None = None) -> None:
        """Declare the first *standing* parts, by default all, in this order; return at once.

        The others can be requested with `ask`. Declared parts that are not in *parts* are undeclared.
        """
        with self._changed:
            self._wanted = parts, len(parts) if standing is None else standing
            self._changed.notify()
            if self._thread is None and not self._closed:
                self._thread = threading.Thread(target=self._run, name="hmrsim-ros2-tokens", daemon=True)
                self._thread.start()

    def ask(self, part: Part) -> None:
        """Declare one more part, before the remaining standing ones; from any thread, return at once."""
        with self._changed:
            self._requested[part] = None
            self._changed.notify()

    def close(self) -> None:
        """Stop declaring, before the session is closed; closing the session undeclares everything.

        Returns when the declaration in progress is done, after `_JOIN_SECONDS` at the latest: closing a session during
        a declaration can deadlock in Zenoh for 10 s or more.
        """
        with self._changed:
            self._closed = True
            self._changed.notify()
        if self._thread is not None:
            self._thread.join(_JOIN_SECONDS)

    def _run(self) -> None:
        try:
            while not self._closed:
                wanted = self._next()
                if wanted is not None:
                    self._apply(*wanted)
                self._declare_requested()
        except (zenoh.ZError, RuntimeError) as error:
            if not self._closed:
                _log.exception("declaring to ROS")
            _log.debug("the session was closed: %s", error)

    def _next(self) -> tuple[Sequence[Part], int] | None:
        with self._changed:
            self._changed.wait_for(lambda: self._closed or self._wanted is not None or self._requested)
            wanted, self._wanted = self._wanted, None
        return wanted

    def _apply(self, parts: Sequence[Part], standing: int | None = None) -> None:
        """Undeclare all other parts and declare the standing ones, until `want` is called again."""
        self._existing = frozenset(parts)
        for part in [part for part in self._parts if part not in self._existing]:
            if self._closed:
                return
            self._undeclare(part)
        for part in parts[:standing]:
            self._declare_requested()
            if self._wanted is not None:
                return
            if part not in self._parts:
                self._declare(part)

    def _declare_requested(self) -> None:
        """Declare the parts requested with `ask`, until `want` is called again: it may include the rest."""
        while self._requested and not self._closed:
            with self._changed:
                if self._wanted is not None:
                    return
                part = next(iter(self._requested))
                del self._requested[part]
            if part in self._existing and part not in self._parts:
                self._declare(part)

    def _declare(self, part: Part) -> None:
        declared = self._parts[part] = []
        for node in part.nodes if self._has_tokens else ():
            if self._closed:
                return
            with self._logging_failure(_NOT_DECLARED, node.full_name):
                self._use_node(node)
                self._nodes_of_parts.setdefault(part, []).append(node)
        for owned in self._endpoints_of(part):
            if self._closed:
                return
            with self._logging_failure(_NOT_DECLARED, owned.endpoint.name):
                declared.append((owned, self._declare_endpoint(owned)))

    @contextmanager
    def _logging_failure(self, message: str, name: str) -> Iterator[None]:
        """Log a failure and continue with the rest, unless the session is being closed."""
        try:
            yield
        except (zenoh.ZError, RuntimeError) as error:
            # zenoh-python raises RuntimeError if another thread uses the object to be changed.
            # Not Session.is_closed(): it raises RuntimeError while another thread closes the session.
            if self._closed:
                raise
            _log.warning(message, name, error)

    def _declare_endpoint(self, owned: Owned) -> _Declared | None:
        """Open the publisher of an endpoint, if it has one, and declare its token; None without tokens."""
        endpoint = owned.endpoint
        if not self._has_tokens:
            self._open_publisher(endpoint, None)
            return None
        ids = self._use_node(owned.node), next(self._ids)
        token = keys.endpoint_token(self._domain, self._session_id, ids, owned.node, endpoint)
        with ExitStack() as undoing:
            undoing.callback(self._release_node, owned.node)
            self._open_publisher(endpoint, keys.gid(token))
            undoing.callback(self._close_publisher, endpoint)
            declared = _Declared(ids[1], self._liveliness.declare_token(token))
            undoing.pop_all()
        return declared

    def _open_publisher(self, endpoint: Endpoint, gid: bytes | None) -> None:
        if endpoint.kind is Kind.PUBLISHER:
            self._publishers.open(endpoint, gid)

    def _close_publisher(self, endpoint: Endpoint) -> None:
        if endpoint.kind is Kind.PUBLISHER:
            self._publishers.close(endpoint)

    def _use_node(self, node: Node) -> int:
        """Declare a node, or count one more use of it; return its id."""
        declared = self._nodes.get(node)
        if declared is None:
            if node.namespace not in self._numbers:
                if not self._named % _SHARE:
                    self._number = next(self._ids)
                self._named += 1
                self._numbers[node.namespace] = self._number
            number = self._numbers[node.namespace]
            token = keys.node_token(self._domain, self._session_id, number, node)
            declared = self._nodes[node] = _Declared(number, self._liveliness.declare_token(token), uses=0)
            self._nodes_of_namespace[node.namespace] += 1
        declared.uses += 1
        return declared.id

    def _undeclare(self, part: Part) -> None:
        for owned, declared in self._parts.pop(part):
            undoing: list[Callable[[], None]] = [partial(self._close_publisher, owned.endpoint)]
            if declared is not None:
                undoing = [declared.token.undeclare, *undoing, partial(self._release_node, owned.node)]
            for undo in undoing:
                with self._logging_failure(_NOT_UNDECLARED, owned.endpoint.name):
                    undo()
        for node in self._nodes_of_parts.pop(part, ()):
            with self._logging_failure(_NOT_UNDECLARED, node.full_name):
                self._release_node(node)

    def _release_node(self, node: Node) -> None:
        """Count one use less of a node, and undeclare it after the last one."""
        declared = self._nodes[node]
        declared.uses -= 1
        if not declared.uses:
            del self._nodes[node]
            self._nodes_of_namespace[node.namespace] -= 1
            if not self._nodes_of_namespace[node.namespace]:
                del self._nodes_of_namespace[node.namespace], self._numbers[node.namespace]
            declared.token.undeclare()
