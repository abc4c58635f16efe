"""A request of a ROS client that awaits its reply: it gets exactly one in any case."""

from __future__ import annotations

import logging
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import zenoh

from hmrsim_zenoh.ros2.attachment import Attachment, read_attachment
from hmrsim_zenoh.ros2.codec.cdr import CdrError

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
        """Send the one reply."""
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
