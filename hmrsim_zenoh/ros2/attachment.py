"""What rmw_zenoh attaches to each message, request and reply: 33 bytes.

The sequence number and the time in nanoseconds as int64, the length of the id as one byte, and the sender's id.
"""

from __future__ import annotations

from struct import Struct
from typing import Final, NamedTuple

_LAYOUT: Final = Struct("<qqB16s")
_ID_BYTES: Final = 16


class Attachment(NamedTuple):
    """The sender of a message, request or reply, and the sequence number.

    Attributes:
        sequence: Counts from 1 for each sender. A reply has that of its request.
        stamp: Nanoseconds since 1970, of the wall clock.
        gid: 16 bytes. A reply has that of its request.
    """

    sequence: int
    stamp: int
    gid: bytes

    def to_bytes(self) -> bytes:
        """Return the attachment."""
        return _LAYOUT.pack(self.sequence, self.stamp, _ID_BYTES, self.gid)


def read_attachment(data: bytes) -> Attachment:
    """Return a parsed attachment.

    Raises:
        ValueError: It has not rmw_zenoh's layout.
    """
    if len(data) != _LAYOUT.size:
        raise ValueError(f"an attachment of {len(data)} bytes; rmw_zenoh's has {_LAYOUT.size}")
    sequence, stamp, length, gid = _LAYOUT.unpack(data)
    if length != _ID_BYTES:
        raise ValueError(f"an attachment with an id of {length} bytes; rmw_zenoh's has {_ID_BYTES}")
    return Attachment(sequence, stamp, gid)
