"""The other participants of a ROS domain, as known from the liveliness tokens of their nodes and endpoints.

ROS ignores type hashes in service discovery: a client whose types differ from the simulator's finds the server, sends
a request and waits forever. The simulator logs the difference and the remedy, once for each client.

Where a pattern can exclude the simulator's own tokens, it does: Zenoh compares each new token with all others that
match the same pattern.
"""

from __future__ import annotations

import logging
import re
import threading
from collections import Counter
from collections.abc import Callable, Collection
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Final

import zenoh

from hmrsim_zenoh.ros2 import keys
from hmrsim_zenoh.ros2.keys import Address, Kind, numbered
from hmrsim_zenoh.ros2.type_compat import difference

if TYPE_CHECKING:
    from hmrsim_zenoh.ros2.keys import Endpoint, Token, TypeHash
    from hmrsim_zenoh.ros2.rejection_log import RejectionLog

_log = logging.getLogger(__name__)

_MAX_SESSIONS: Final = 256
"""The largest number of remote sessions whose services are watched."""
_MAX_ENDPOINTS: Final = 10_000
"""The largest number of remote endpoints that are remembered."""
_SHOWN: Final = 200
"""Characters of an unreadable token that are shown."""

_CLOCK: Final = "/clock"
_SESSION: Final = re.compile("[0-9a-f]{1,32}")
_WHAT: Final = {Kind.CLIENT: "client", Kind.SUBSCRIBER: "subscriber"}


class Peers:
    """Watches the tokens of a ROS domain, and warns of clients that can't work with the simulator.

    Args:
        session: The session to watch on; its own tokens are ignored.
        domain: The number of the ROS domain.
        served: Returns types and hashes of the simulator's endpoints with a name.
        rejections: Logs each warning once.
        came: Called with the name of a remote client's or subscriber's endpoint; in a thread of Zenoh's.
        gone: Called with the gid of a service client that has gone; in a thread of Zenoh's.
    """

    def __init__(
        self,
        session: zenoh.Session,
        domain: int,
        *,
        served: Callable[[str], Collection[TypeHash]],
        rejections: RejectionLog,
        came: Callable[[str], None],
        gone: Callable[[bytes], None],
    ) -> None:
        self._domain = domain
        self._own = str(session.info.zid())
        self._served = served
        self._due = rejections.due
        self._on_came = came
        self._on_gone = gone
        self._lock = threading.Lock()
        # The tokens of remote clients and subscribers by their gids.
        self._others: dict[bytes, Token] = {}
        # The number of the tokens of each remote session, without those of its services, and what watches these.
        self._sessions: Counter[str] = Counter()
        self._services: dict[str, Any] = {}
        self._liveliness = session.liveliness()
        self._subscribers = [
            self._watch(keys.tokens_of(domain, kind)) for kind in (Kind.CLIENT, Kind.SUBSCRIBER, Kind.NODE)
        ]
        self._subscribers.append(self._watch(keys.publishers_of(domain, _CLOCK), own_thread=False))

    def look(self, new: Callable[[str], bool]) -> None:
        """Check again the known endpoints with new names, after the served names have changed."""
        with self._lock:
            others = list(self._others.values())
        for token in others:
            if token.endpoint is not None and new(token.endpoint.name):
                self._on_came(token.endpoint.name)
                self._compare(token, token.endpoint)

    def wrong_hash(self, address: Address, who: str) -> None:
        """Warn, once for each client, that its type is incompatible, with a remedy.

        Args:
            address: The service that the client has requested.
            who: The client's gid in hex; empty if it has none.
        """
        token = self._token_of(who)
        self._warn(token.session if token else who, self.name_of(who), address)

    def name_of(self, who: str) -> str:
        """Return the name of a client for messages, by its gid in hex: its node if that is known."""
        token = self._token_of(who)
        return f"client {token.node.full_name}" if token else numbered(who)

    def close(self) -> None:
        """Stop watching."""
        for watch in (*self._subscribers, *list(self._services.values())):
            _end(watch)

    def _watch(self, pattern: str, *, own_thread: bool = True) -> Any:
        handler = zenoh.handlers.Callback(self._on_sample, indirect=own_thread)
        return self._liveliness.declare_subscriber(pattern, handler, history=True)

    def _token_of(self, who: str) -> Token | None:
        with self._lock, suppress(ValueError):
            return self._others.get(bytes.fromhex(who))
        return None

    def _on_sample(self, sample: zenoh.Sample) -> None:
        text = str(sample.key_expr)
        try:
            if sample.kind == zenoh.SampleKind.PUT:
                self._came(text)
            else:
                self._went(text)
        except Exception:  # noqa: BLE001 - an invalid token of another program must not end the watch
            _log.exception("reading the token %r", text[:_SHOWN])

    def _came(self, text: str) -> None:
        token = keys.read_token(text)
        if token is None:
            self._warn_unreadable(text)
        elif token.session != self._own:
            if token.endpoint is None:
                self._session_came(token.session)
            elif token.endpoint.kind in _WHAT:
                self._session_came(token.session)
                with self._lock:
                    if len(self._others) < _MAX_ENDPOINTS:
                        self._others[keys.gid(text)] = token
                self._on_came(token.endpoint.name)
                self._compare(token, token.endpoint)
            elif token.endpoint.kind is Kind.SERVICE:
                self._contest(token, token.endpoint)
            elif token.endpoint.name == _CLOCK and self._due(("clock", token.session)):
                _log.warning(
                    "ROS domain %d: node %s publishes /clock, too: nodes with use_sim_time see time jump; "
                    "run one of them with another --ros-domain-id",
                    *(self._domain, token.node.full_name),
                )

    def _session_came(self, session: str) -> None:
        """Count a new token of a session; its services are watched from its first token on."""
        with self._lock:
            known = session in self._sessions
            if not known and len(self._sessions) >= _MAX_SESSIONS:
                return
            self._sessions[session] += 1
        if not known and _SESSION.fullmatch(session):
            watch = self._watch(keys.tokens_of(self._domain, Kind.SERVICE, session), own_thread=False)
            with self._lock:
                if session in self._sessions:
                    self._services[session] = watch

    def _session_went(self, session: str) -> None:
        """Count a token of a session as gone; its services are watched until its last token has gone."""
        with self._lock:
            if session not in self._sessions:
                return
            self._sessions[session] -= 1
            if self._sessions[session]:
                return
            del self._sessions[session]
            watch = self._services.pop(session, None)
        _end(watch)

    def _went(self, text: str) -> None:
        token = keys.read_token(text)
        if token is None or token.session == self._own:
            return
        kind = token.endpoint.kind if token.endpoint else Kind.NODE
        if kind in (Kind.SERVICE, Kind.PUBLISHER):
            return
        gid = keys.gid(text)
        with self._lock:
            self._others.pop(gid, None)
        if kind is Kind.CLIENT:
            self._on_gone(gid)
        self._session_went(token.session)

    def _compare(self, token: Token, endpoint: Endpoint) -> None:
        served = self._served(endpoint.name)
        if served and (endpoint.type, endpoint.hash) not in served:
            address = Address(endpoint.name, endpoint.type, endpoint.hash)
            self._warn(token.session, f"{_WHAT[endpoint.kind]} {token.node.full_name}", address)

    def _warn(self, whose: str, who: str, address: Address) -> None:
        served = self._served(address.name)
        # One warning for each type: a program that talks to many robots has the same problem with each.
        if not served or not self._due((whose, address.type, address.hash)):
            return
        what, remedy = difference((address.type, address.hash), served)
        _log.warning("ROS domain %d: %s is incompatible with %s: %s; %s", self._domain, who, address.name, what, remedy)

    def _contest(self, token: Token, endpoint: Endpoint) -> None:
        if self._served(endpoint.name) and self._due(("contest", token.session)):
            robot, _, name = endpoint.name[1:].partition("/")
            _log.warning(
                "ROS domain %d: node %s serves %s, too: both execute each goal%s, and a client gets the reply "
                "of either; run one of them with another --ros-domain-id, or rename its robots",
                *(self._domain, token.node.full_name, endpoint.name),
                f" of {robot}" if name and not name.startswith("_action/") else "",
            )

    def _warn_unreadable(self, text: str) -> None:
        shown = text[:_SHOWN]
        if self._due(shown):
            _log.warning("ROS domain %d: ignored %r, which is not a token of rmw_zenoh", self._domain, shown)


def _end(watch: Any) -> None:
    if watch is not None:
        # RuntimeError: another thread ends it, too.
        with suppress(zenoh.ZError, RuntimeError):
            watch.undeclare()
