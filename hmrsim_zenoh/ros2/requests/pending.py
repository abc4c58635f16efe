"""A request of a ROS client that awaits its reply: it gets exactly one, whatever comes of it."""

from __future__ import annotations

import logging
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import zenoh

from hmrsim_zenoh.ros2.attachment import Attachment, read_attachment
from hmrsim_zenoh.ros2.codec.cdr import CdrError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from hmrsim.interfaces.message import Message
    from hmrsim_zenoh.ros2.codec.types import ServiceType
    from hmrsim_zenoh.ros2.requests.handlers import Offer
    from hmrsim_zenoh.ros2.wires import Wire

_log = logging.getLogger(__name__)

NOBODY: Final = Attachment(0, 0, bytes(16))
"""What stands for an attachment that can't be read."""


@dataclass(frozen=True, slots=True, eq=False)
class PendingRosReply:
    """A query, and what is known of it.

    Attributes:
        query: Zenoh's.
        wire: On which it came.
        offer: What it is about.
        type: The layout that its client has.
        attached: Who sent it; None where the wire doesn't tell.
    """

    query: zenoh.Query
    wire: Wire
    offer: Offer
    type: ServiceType
    attached: Attachment | None

    @property
    def client(self) -> str:
        """The client's id in hex; empty if it has none."""
        return self.attached.gid.hex() if self.attached and any(self.attached.gid) else ""

    def answer(self, answer: Any) -> None:
        """Send what came of the command, as this client reads it."""
        self.reply(self.offer.answer(answer))

    def refuse(self, text: str) -> None:
        """Send that it came to nothing; *text* says why, where there is a field for it."""
        self.reply(self.offer.refusal(text))

    def reply(self, values: Message | Mapping[str, Any]) -> None:
        """Send the one reply."""
        try:
            self.query.reply(self.query.key_expr, self._encoded(values), attachment=self._attachment())
        except zenoh.ZError as error:
            _log.debug("replying to %s: %s", self.offer.name, error)
        finally:
            self.query.drop()

    def _encoded(self, values: Message | Mapping[str, Any]) -> bytes:
        encode = self.type.response.encode
        try:
            return encode(values)
        except CdrError as error:
            _log.exception("the reply of %s can't be put into ROS's bytes", self.offer.name)
            return encode(self.offer.refusal(f"the simulator has a bug: {error}"))

    def _attachment(self) -> zenoh.ZBytes | bytes | None:
        """Return the request's, as ROS wants it: all but the time; as it came where the wire doesn't say."""
        if self.attached is None:
            return self.query.attachment
        return self.attached._replace(stamp=time.time_ns()).to_bytes()


def attached_to(query: zenoh.Query) -> Attachment:
    """Return what rmw_zenoh attached to a query.

    Raises:
        ValueError: Nothing, or something else.
    """
    attached = query.attachment
    if attached is None:
        raise ValueError("nothing is attached, and rmw_zenoh attaches who asks; see docs/ros2.md")
    return read_attachment(attached.to_bytes())
