"""The publishers of a ROS 2 wire: each is closed until its liveliness token is about to be declared."""

from __future__ import annotations

import logging
import threading
import time
import weakref
from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Any, ClassVar

import zenoh

from hmrsim_zenoh.ros2.keys import LATCHED_QOS
from hmrsim_zenoh.ros2.wires import Attachment
from hmrsim_zenoh.wire.keys import HISTORY, servers_own

if TYPE_CHECKING:
    from hmrsim.interfaces.message import Message
    from hmrsim_zenoh.ros2.keys import Endpoint
    from hmrsim_zenoh.ros2.publishing.endpoints import Endpoints
    from hmrsim_zenoh.ros2.wires import Wire

_log = logging.getLogger(__name__)

_BLOCK, _DROP = zenoh.CongestionControl.BLOCK, zenoh.CongestionControl.DROP


class Publisher:
    """A publisher that numbers its messages from 1 and drops them while it is closed; for any thread.

    Attributes:
        keeps: Whether a message that is published while it is closed is not lost.
    """

    keeps: ClassVar[bool] = False

    def __init__(self) -> None:
        # The simulation thread publishes; the declaration thread opens and closes.
        self._lock = threading.Lock()
        self._put: Callable[..., None] | None = None
        self._gid: bytes | None = None
        self._count = 0

    def __bool__(self) -> bool:
        """Return whether the publisher is open."""
        return self._put is not None

    def open(self, put: Callable[..., None], gid: bytes | None) -> None:
        """Open the publisher.

        Args:
            put: Accepts a payload, and an attachment if there is a *gid*.
            gid: The publisher's id; None on a wire without attachments.
        """
        with self._lock:
            self._gid, self._count = gid, 0
            self._put = put
            self._opened()

    def close(self) -> None:
        """Close the publisher; returns after a put in progress, so that the caller may undeclare the entity."""
        with self._lock:
            self._put = None

    def publish(self, payload: bytes) -> None:
        """Publish a message; it is dropped under congestion, unless the publisher is latched."""
        with self._lock:
            self._publish(payload)

    def _opened(self) -> None:
        """Run after the publisher has opened, with the lock held."""

    def _publish(self, payload: bytes) -> None:
        """Put a payload if the publisher is open, with the lock held."""
        if self._put is None:
            return
        self._count += 1
        options: dict[str, Any] = {}
        if self._gid is not None:
            options["attachment"] = Attachment(self._count, time.time_ns(), self._gid).to_bytes()
        try:
            self._put(payload, **options)
        except zenoh.ZError as error:
            _log.debug("publishing: %s", error)


class LatchedPublisher(Publisher):
    """A publisher that keeps its last message and publishes it again when it opens."""

    keeps = True

    def __init__(self) -> None:
        super().__init__()
        self._last: bytes | None = None

    def _opened(self) -> None:
        if self._last is not None:
            super()._publish(self._last)

    def _publish(self, payload: bytes) -> None:
        self._last = payload
        super()._publish(payload)


class _Outlet:
    """A key to publish on; it is declared with the first message, as most keys never have one."""

    def __init__(self, session: zenoh.Session, key: str) -> None:
        self.key = key
        self._session = session
        self._declared: zenoh.KeyExpr | None = None

    def put(self, payload: bytes, **options: Any) -> None:
        self._put(payload, congestion_control=_DROP, **options)

    def undeclare(self) -> None:
        if self._declared is not None:
            self._session.undeclare(self._declared)

    def _put(self, payload: bytes, **options: Any) -> None:
        # Zenoh matches an undeclared key against all declared ones.
        if self._declared is None:
            self._declared = self._session.declare_keyexpr(self.key)
        self._session.put(self._declared, payload, **options)


class _LatchedOutlet(_Outlet):
    """A key whose last message late subscribers get, and whose token makes earlier ones query it.

    Zenoh's own publisher of this kind has a queryable, which costs time for each query of any client.
    """

    def __init__(self, session: zenoh.Session, key: str) -> None:
        super().__init__(session, key)
        self._last: tuple[bytes, dict[str, Any]] | None = None
        self._token = session.liveliness().declare_token(f"{key}/{HISTORY}/pub/{session.info.zid()}/uhlc/_")

    def put(self, payload: bytes, **options: Any) -> None:
        # Subscribers tell from the timestamp that a message of the history is one that they have.
        self._last = payload, {**options, "timestamp": self._session.new_timestamp()}
        self._put(payload, congestion_control=_BLOCK, **self._last[1])

    def undeclare(self) -> None:
        self._token.undeclare()
        super().undeclare()

    def reply_to(self, query: zenoh.Query) -> None:
        """Reply with the last message, if there is one."""
        if self._last is not None:
            payload, options = self._last
            query.reply(self.key, payload, **options)


class Publishers:
    """All publishers of one wire, by their keys."""

    def __init__(self, session: zenoh.Session, wire: Wire) -> None:
        self._session = session
        self._wire = wire
        self._lock = threading.Lock()
        # The publishers that are referenced, and the outlets of the open ones.
        self._all: weakref.WeakValueDictionary[str, Publisher] = weakref.WeakValueDictionary()
        self._outlets: dict[str, tuple[Publisher, _Outlet]] = {}
        everything = zenoh.KeyExpr.autocanonize(wire.key("/**"))
        self._history = session.declare_queryable(
            servers_own(f"{everything}/{HISTORY}/**"), zenoh.handlers.Callback(self._reply_history), complete=False
        )

    def of(self, endpoint: Endpoint) -> Publisher:
        """Return the publisher of an endpoint: always the same object while it is referenced.

        Without tokens to wait for, it is open at once unless it is latched, as that one keeps its message anyway.
        """
        key = self._key_of(endpoint)
        with self._lock:
            publisher = self._all.get(key)
            if publisher is None:
                publisher = self._all[key] = LatchedPublisher() if endpoint.qos == LATCHED_QOS else Publisher()
                if not self._wire.has_types and endpoint.qos != LATCHED_QOS:
                    self._open(key, publisher, _Outlet(self._session, key), None)
        return publisher

    def open(self, endpoint: Endpoint, gid: bytes | None) -> None:
        """Declare a publisher and open it, if it is closed.

        Raises:
            ZError: The session is closed.
        """
        key, publisher = self._key_of(endpoint), self.of(endpoint)
        if not publisher:
            kind = _LatchedOutlet if endpoint.qos == LATCHED_QOS else _Outlet
            self._open(key, publisher, kind(self._session, key), gid)

    def _open(self, key: str, publisher: Publisher, outlet: _Outlet, gid: bytes | None) -> None:
        self._outlets[key] = publisher, outlet
        publisher.open(outlet.put, gid)

    def close(self, endpoint: Endpoint) -> None:
        """Close a publisher, and then undeclare it.

        Raises:
            ZError: The session is closed.
        """
        publisher, outlet = self._outlets.pop(self._key_of(endpoint))
        publisher.close()
        outlet.undeclare()

    def _key_of(self, endpoint: Endpoint) -> str:
        return self._wire.key(endpoint.name, endpoint.type, endpoint.hash)

    def _reply_history(self, query: zenoh.Query) -> None:
        """Reply to a late subscriber with the last message on its key, in a thread of Zenoh."""
        asked = zenoh.KeyExpr(str(query.key_expr).partition(f"/{HISTORY}")[0])
        outlets = self._outlets
        for key in [key for key in list(outlets) if asked.intersects(key)] if "*" in str(asked) else [str(asked)]:
            _, outlet = outlets.get(key, (None, None))
            if isinstance(outlet, _LatchedOutlet):
                with suppress(zenoh.ZError):
                    outlet.reply_to(query)
        query.drop()


class TopicPublishers:
    """Publishes messages on topics of the robots and of the world.

    Publishers that were used are referenced, as latched ones have to keep their message until they are declared.
    """

    def __init__(self, publishers: Publishers, endpoints: Endpoints) -> None:
        self._publishers = publishers
        self._endpoints = endpoints
        self._used: dict[tuple[str, str], Publisher] = {}

    def publish(self, robot: str, topic: str, message: Message | Mapping[str, Any] | bytes) -> None:
        """Publish a message or an encoded one; nothing is encoded for a closed publisher that does not keep it."""
        publisher = self._used.get((robot, topic))
        if publisher is None:
            publisher = self._used[robot, topic] = self._publishers.of(self._endpoints.topic(robot, topic).endpoint)
        if publisher or publisher.keeps:
            publisher.publish(message if isinstance(message, bytes) else self.encoded(topic, message))

    def encoded(self, topic: str, message: Message | Mapping[str, Any]) -> bytes:
        """Return an encoded message of a topic."""
        return self._endpoints.message_type(topic).encode(message)

    def forget(self, robots: Collection[str]) -> None:
        """Drop the publishers of all robots but these."""
        self._used = {key: publisher for key, publisher in self._used.items() if key[0] in robots}
