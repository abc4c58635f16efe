"""Who is connected to a secured simulator, by the names on the certificates."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Final

import zenoh

from hmrsim.errors import printable
from hmrsim_zenoh.wire import encoding
from hmrsim_zenoh.wire.envelopes import dump

if TYPE_CHECKING:
    from hmrsim_zenoh.wire.access_control import AccessControl

_MAX_TOLD: Final = 100
"""The number of names without rights that are logged, each once."""

_log = logging.getLogger(__name__)


class Sessions:
    """Follows the connections, and logs those who have no rights: Zenoh lets them in, and drops what they send.

    Attributes:
        policy: What the session enforces.
    """

    mime: Final = f"{encoding.JSON};hmrsim/Sessions"

    def __init__(self, session: zenoh.Session, policy: AccessControl) -> None:
        self.policy = policy
        self._names: dict[str, str] = {}
        self._told: set[str] = set()
        handler = zenoh.handlers.Callback(self._on_event, indirect=False)
        self._listener = session.info.declare_link_events_listener(handler, history=True)

    def payload(self) -> bytes:
        """Return the name on the certificate of each session."""
        return dump({"sessions": [{"session": zid, "name": name} for zid, name in sorted(self._names.copy().items())]})

    def _on_event(self, event: zenoh.LinkEvent) -> None:
        """Take a connection that came or went; in Zenoh's thread."""
        zid, name = str(event.link.zid), event.link.auth_identifier or ""
        if event.kind == zenoh.SampleKind.DELETE:
            self._names.pop(zid, None)
            return
        self._names[zid] = name
        if name not in self.policy.rules and name not in self._told and len(self._told) < _MAX_TOLD:
            self._told.add(name)
            _log.warning("%r is denied everything: it is revoked, or no member of the policy", printable(name))
