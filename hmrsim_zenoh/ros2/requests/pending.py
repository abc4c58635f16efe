"""Requests of ROS clients that await a reply; each gets exactly one.

The pending get_result requests are counted by client: those of a gone client are dropped, and their number is limited.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import zenoh

from hmrsim.protocol.commands import GetResult, StopWaiting
from hmrsim_zenoh.ros2.codec.layout import CdrError
from hmrsim_zenoh.ros2.wires import Attachment, read_attachment

if TYPE_CHECKING:
    from hmrsim.interfaces.message import Message
    from hmrsim_zenoh.ros2.codec.types import ServiceType
    from hmrsim_zenoh.ros2.requests.handlers import Handler
    from hmrsim_zenoh.ros2.wires import Wire

_log = logging.getLogger(__name__)

NO_ATTACHMENT: Final = Attachment(0, 0, bytes(16))
"""The substitute for a missing or invalid attachment."""


@dataclass(frozen=True, slots=True, eq=False)
class PendingRosReply:
    """A query and its parsed key and attachment.

    Attributes:
        type: The client's layout of the service.
        attached: The attachment, which identifies the client; None on a wire without attachments.
    """

    query: zenoh.Query
    wire: Wire
    handler: Handler
    type: ServiceType
    attached: Attachment | None

    @property
    def client(self) -> str:
        """The client's id in hex; empty if it has none."""
        return self.attached.gid.hex() if self.attached and any(self.attached.gid) else ""

    def answer(self, answer: Any) -> None:
        """Send the answer to the command, in the client's layout."""
        self.reply(self.handler.answer(answer))

    def refuse(self, text: str) -> None:
        """Reject the request; *text* is the reason, if the response has a field for it."""
        self.reply(self.handler.refusal(text))

    def reply(self, values: Message | Mapping[str, Any]) -> None:
        """Send the only reply to the request."""
        try:
            self.query.reply(self.query.key_expr, self._encoded(values), attachment=self._attachment())
        except zenoh.ZError as error:
            _log.debug("replying to %s: %s", self.handler.name, error)
        finally:
            self.query.drop()

    def _encoded(self, values: Message | Mapping[str, Any]) -> bytes:
        encode = self.type.response.encode
        try:
            return encode(values)
        except CdrError as error:
            _log.exception("the reply of %s can't be serialised", self.handler.name)
            return encode(self.handler.refusal(f"the simulator has a bug: {error}"))

    def _attachment(self) -> zenoh.ZBytes | bytes | None:
        """Return the request's attachment, with the current time; unchanged on a wire without attachments."""
        if self.attached is None:
            return self.query.attachment
        return self.attached._replace(stamp=time.time_ns()).to_bytes()


def attached_to(query: zenoh.Query) -> Attachment:
    """Return the attachment of a query.

    Raises:
        ValueError: There is none, or it is invalid.
    """
    attached = query.attachment
    if attached is None:
        raise ValueError(
            "the request has no attachment, by which rmw_zenoh identifies the client; see docs/reference/ros2.md"
        )
    return read_attachment(attached.to_bytes())


MAX_WAITING: Final = 16_384
"""The largest number of pending requests for results."""
MAX_PER_CLIENT: Final = 1_024
"""The largest number of pending requests of one client."""
MAX_ANONYMOUS: Final = 32
"""The largest number for one goal, of clients without an id: it is unknown when they leave; most gave up long ago."""


class PendingResults:
    """The requests for results that have not been answered; for any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._of: dict[str, dict[PendingRosReply, GetResult]] = {}
        self._owners: dict[PendingRosReply, str] = {}

    def add(self, pending: PendingRosReply, command: GetResult) -> list[StopWaiting]:
        """Remember a request; return the commands that drop another one if there are too many now.

        That is the oldest of the same client, or the oldest of the client with the most if the total is too large.
        """
        owner = pending.client or f"goal {command.goal_id}"
        with self._lock:
            requests = self._of.setdefault(owner, {})
            requests[pending], self._owners[pending] = command, owner
            if len(requests) > (MAX_PER_CLIENT if pending.client else MAX_ANONYMOUS):
                return self._make_room(owner)
            if len(self._owners) > MAX_WAITING:
                return self._make_room(max(self._of, key=lambda one: len(self._of[one])))
        return []

    def answered(self, pending: PendingRosReply) -> None:
        """Forget a request that has been answered."""
        with self._lock:
            self._forget(pending)

    def gone(self, client: str) -> list[StopWaiting]:
        """Forget all requests of a client that has gone; return the commands that drop them."""
        with self._lock:
            requests = self._of.pop(client, {})
            for pending in requests:
                del self._owners[pending]
        return _stop_waiting(requests)

    def _make_room(self, owner: str) -> list[StopWaiting]:
        pending, command = next(iter(self._of[owner].items()))
        self._forget(pending)
        return [stop._replace(tell=True) for stop in _stop_waiting({pending: command})]

    def _forget(self, pending: PendingRosReply) -> None:
        owner = self._owners.pop(pending, None)
        if owner is not None:
            del self._of[owner][pending]
            if not self._of[owner]:
                del self._of[owner]


def _stop_waiting(requests: Mapping[PendingRosReply, GetResult]) -> list[StopWaiting]:
    """Return the commands that drop requests, one for each goal."""
    of_goals: dict[tuple[str, str, str], list[PendingRosReply]] = {}
    for pending, command in requests.items():
        of_goals.setdefault((command.robot, command.action, command.goal_id), []).append(pending)
    return [StopWaiting(*goal, tuple(found)) for goal, found in of_goals.items()]
