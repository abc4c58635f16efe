"""Where publishers put what they say: at first they are shut, and open once the network knows of them."""

from __future__ import annotations

import logging
import threading
import time
import weakref
from typing import TYPE_CHECKING, Any, Final

import zenoh
from zenoh import ext

from hmrsim_zenoh.ros2.attachment import Attachment
from hmrsim_zenoh.ros2.keys import LATCHED_QOS

if TYPE_CHECKING:
    from collections.abc import Callable

    from hmrsim_zenoh.ros2.keys import Endpoint
    from hmrsim_zenoh.ros2.wires import Wire

_log = logging.getLogger(__name__)

_DROP: Final = zenoh.CongestionControl.DROP
_HEARTBEAT: Final = 0.5
"""The heartbeat period in seconds, by which subscribers detect a missed message, as in rmw_zenoh."""


class Outlet:
    """What one publisher says, numbered from 1; nothing while it is shut. From any thread."""

    def __init__(self) -> None:
        # The simulation's thread sends, the declarations' thread opens and shuts.
        self._lock = threading.Lock()
        self._put: Callable[..., None] | None = None
        self._gid: bytes | None = None
        self._count = 0

    def __bool__(self) -> bool:
        """Return whether it is open."""
        return self._put is not None

    def open(self, put: Callable[..., None], gid: bytes | None) -> None:
        """Begin; *put* takes what is said, and an attachment with the publisher's id unless that is None."""
        with self._lock:
            self._gid, self._count = gid, 0
            self._put = put
            self._opened()

    def shut(self) -> None:
        """End; waits for a put that is running, so that the caller may undeclare what it puts on."""
        with self._lock:
            self._put = None

    def send(self, payload: bytes) -> None:
        """Say something; it is lost if the network does not take it at once."""
        with self._lock:
            self._send(payload)

    def _opened(self) -> None:
        """Do what opening entails; the lock is held."""

    def _send(self, payload: bytes) -> None:
        """Put a payload unless the outlet is shut; the lock is held."""
        if self._put is None:
            return
        self._count += 1
        said: dict[str, Any] = {}
        if self._gid is not None:
            said["attachment"] = Attachment(self._count, time.time_ns(), self._gid).to_bytes()
        try:
            self._put(payload, **said)
        except zenoh.ZError as error:
            _log.debug("publishing: %s", error)


class Latched(Outlet):
    """An outlet that keeps its last message, and sends it again when it opens."""

    def __init__(self) -> None:
        super().__init__()
        self._last: bytes | None = None

    def _opened(self) -> None:
        if self._last is not None:
            super()._send(self._last)

    def _send(self, payload: bytes) -> None:
        self._last = payload
        super()._send(payload)


class _Key:
    """A key to publish on; Zenoh is told of it with the first message, as most keys never have one."""

    def __init__(self, session: zenoh.Session, key: str) -> None:
        self._session = session
        self._key = key
        self._declared: zenoh.KeyExpr | None = None

    def put(self, payload: bytes, **said: Any) -> None:
        # Zenoh compares a key that it does not know with all that it does.
        if self._declared is None:
            self._declared = self._session.declare_keyexpr(self._key)
        self._session.put(self._declared, payload, congestion_control=_DROP, **said)

    def undeclare(self) -> None:
        if self._declared is not None:
            self._session.undeclare(self._declared)


class Outlets:
    """All of one wire, by their keys.

    Args:
        session: Where they publish.
        wire: How keys are spelled.
    """

    def __init__(self, session: zenoh.Session, wire: Wire) -> None:
        self._session = session
        self._wire = wire
        self._lock = threading.Lock()
        # Those that somebody holds, and the open ones by these.
        self._all: weakref.WeakValueDictionary[str, Outlet] = weakref.WeakValueDictionary()
        self._publishers: dict[str, tuple[Outlet, ext.AdvancedPublisher | _Key]] = {}

    def of(self, endpoint: Endpoint) -> Outlet:
        """Return the outlet of a publisher: always the same, as long as it is referenced.

        It is open if there is no token that it would have to wait for, unless it is latched, which keeps what is said.
        """
        key = self._key_of(endpoint)
        with self._lock:
            found = self._all.get(key)
            if found is None:
                found = self._all[key] = Latched() if endpoint.qos == LATCHED_QOS else Outlet()
                if not self._wire.tells_types and endpoint.qos != LATCHED_QOS:
                    self._open(key, found, _Key(self._session, key), None)
        return found

    def open(self, endpoint: Endpoint, gid: bytes | None) -> None:
        """Declare a publisher, and let it speak if it does not yet.

        Raises:
            ZError: The session is closed.
        """
        key, outlet = self._key_of(endpoint), self.of(endpoint)
        if not outlet:
            publisher = self._advanced(key) if endpoint.qos == LATCHED_QOS else _Key(self._session, key)
            self._open(key, outlet, publisher, gid)

    def _open(self, key: str, outlet: Outlet, publisher: ext.AdvancedPublisher | _Key, gid: bytes | None) -> None:
        self._publishers[key] = outlet, publisher
        outlet.open(publisher.put, gid)

    def shut(self, endpoint: Endpoint) -> None:
        """Let a publisher speak no more, and undeclare it.

        Raises:
            ZError: The session is closed.
        """
        outlet, publisher = self._publishers.pop(self._key_of(endpoint))
        outlet.shut()
        publisher.undeclare()

    def _key_of(self, endpoint: Endpoint) -> str:
        return self._wire.key(endpoint.name, endpoint.type, endpoint.hash)

    def _advanced(self, key: str) -> ext.AdvancedPublisher:
        return ext.declare_advanced_publisher(
            self._session,
            key,
            congestion_control=_DROP,
            cache=ext.CacheConfig(1),
            publisher_detection=True,
            sample_miss_detection=ext.MissDetectionConfig(heartbeat=None, sporadic_heartbeat=_HEARTBEAT),
        )
