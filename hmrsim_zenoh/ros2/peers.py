"""Who else is on our domain, by the liveliness tokens of ROS's nodes and endpoints.

ROS takes no notice of hashes when it looks for a server: a client whose types differ from ours finds one, asks, and
waits for ever. So we say what differs and what to do, once for each client.
"""

from __future__ import annotations

import logging
import threading
from collections import OrderedDict
from contextlib import suppress
from typing import TYPE_CHECKING, Final

import zenoh

from hmrsim_zenoh.ros2 import keys
from hmrsim_zenoh.ros2.hashes import difference
from hmrsim_zenoh.ros2.keys import Address, Kind

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable, Mapping

    from hmrsim_zenoh.ros2.hashes import Spoken
    from hmrsim_zenoh.ros2.keys import Endpoint, Token

_log = logging.getLogger(__name__)

_MOST: Final = 10_000
"""Endpoints of others that are remembered, and things that are said once."""
_MOST_BAD: Final = 20
"""Tokens that nobody can read, and of which we say so."""
_SHOWN: Final = 200
"""Characters that are shown of one."""

_WHAT: Final = {Kind.CLIENT: "client", Kind.SUBSCRIBER: "subscriber"}


class Peers:
    """Watches the tokens of a domain.

    Args:
        session: Where to watch; its own tokens are overlooked.
        domain: ROS's domain id.
        served: Gives what we serve and publish: types and hashes by name.
        gone: Told the id of a service's client that has gone; in a thread of Zenoh's.
    """

    def __init__(
        self,
        session: zenoh.Session,
        domain: int,
        *,
        served: Callable[[], Mapping[str, set[Spoken]]],
        gone: Callable[[bytes], None],
    ) -> None:
        self._domain = domain
        self._own = str(session.info.zid())
        self._served = served
        self._gone = gone
        self._lock = threading.Lock()
        # Who asks or listens, by the id that its messages have.
        self._others: dict[bytes, Token] = {}
        self._said: OrderedDict[Hashable, None] = OrderedDict()
        self._bad = 0
        self._subscriber = session.liveliness().declare_subscriber(
            keys.all_tokens(domain), zenoh.handlers.Callback(self._on_sample), history=True
        )

    def look(self) -> None:
        """Look again at those who are there already, after more is served."""
        with self._lock:
            others = list(self._others.values())
        for token in others:
            if token.endpoint is not None:
                self._compare(token, token.endpoint)

    def wrong_hash(self, address: Address, who: str) -> None:
        """Say once for each client why it is not understood, and what to do.

        Args:
            address: What it asked.
            who: The client's id in hex; empty if it has none.
        """
        with suppress(ValueError):
            with self._lock:
                token = self._others.get(bytes.fromhex(who))
            if token is not None:
                self._warn(token.session, f"client {token.node.full_name}", address)
                return
        self._warn(who, f"client {who}" if who else "a client without an id", address)

    def close(self) -> None:
        """Watch no longer."""
        with suppress(zenoh.ZError):
            self._subscriber.undeclare()

    def _on_sample(self, sample: zenoh.Sample) -> None:
        text = str(sample.key_expr)
        try:
            if sample.kind == zenoh.SampleKind.PUT:
                self._came(text)
            else:
                self._went(text)
        except Exception:  # noqa: BLE001 - whatever others declare, we go on
            _log.exception("reading the token %r", text[:_SHOWN])

    def _came(self, text: str) -> None:
        token = keys.read_token(text)
        if token is None:
            self._say_unreadable(text)
        elif token.session != self._own and token.endpoint is not None:
            if token.endpoint.kind in _WHAT:
                with self._lock:
                    if len(self._others) < _MOST:
                        self._others[keys.gid(text)] = token
                self._compare(token, token.endpoint)
            elif token.endpoint.kind is Kind.SERVICE:
                self._contest(token, token.endpoint)

    def _went(self, text: str) -> None:
        token = keys.read_token(text)
        if token is None or token.endpoint is None or token.session == self._own:
            return
        gid = keys.gid(text)
        with self._lock:
            self._others.pop(gid, None)
        if token.endpoint.kind is Kind.CLIENT:
            self._gone(gid)

    def _compare(self, token: Token, endpoint: Endpoint) -> None:
        spoken = self._served().get(endpoint.name)
        if spoken and (endpoint.type, endpoint.hash) not in spoken:
            address = Address(endpoint.name, endpoint.type, endpoint.hash)
            self._warn(token.session, f"{_WHAT[endpoint.kind]} {token.node.full_name}", address)

    def _warn(self, whose: str, who: str, address: Address) -> None:
        spoken = self._served().get(address.name)
        # A program that talks to many robots would have to be told the same of each.
        if not spoken or not self._first((whose, address.type, address.hash)):
            return
        what, remedy = difference((address.type, address.hash), spoken)
        _log.warning("ROS domain %d: %s does not understand %s: %s; %s", self._domain, who, address.name, what, remedy)

    def _contest(self, token: Token, endpoint: Endpoint) -> None:
        if endpoint.name in self._served() and self._first(("contest", token.session)):
            _log.warning(
                "ROS domain %d: node %s serves %s, too, and clients get the answer of either; give one of us another "
                "--ros-domain-id",
                *(self._domain, token.node.full_name, endpoint.name),
            )

    def _say_unreadable(self, text: str) -> None:
        with self._lock:
            self._bad += 1
            told = self._bad <= _MOST_BAD
        if told:
            more = "; more of them are not told" if self._bad == _MOST_BAD else ""
            _log.warning(
                "ROS domain %d: %r is no token of rmw_zenoh's; overlooked%s", self._domain, text[:_SHOWN], more
            )

    def _first(self, said: Hashable) -> bool:
        """Return whether something is to be said; the oldest are forgotten."""
        with self._lock:
            if said in self._said:
                return False
            self._said[said] = None
            if len(self._said) > _MOST:
                self._said.popitem(last=False)
            return True
