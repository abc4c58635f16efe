"""The events of service introspection."""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field

from hmrsim.interfaces.builtin_interfaces import Time
from hmrsim.interfaces.message import Array, Int64, Message, UInt8


class ServiceEventInfo(Message):
    """The caller or server, and the time; part of the type of every service."""

    REQUEST_SENT: ClassVar[int] = 0
    REQUEST_RECEIVED: ClassVar[int] = 1
    RESPONSE_SENT: ClassVar[int] = 2
    RESPONSE_RECEIVED: ClassVar[int] = 3

    event_type: UInt8 = 0
    stamp: Time = Field(default_factory=Time)
    client_gid: Annotated[list[UInt8], Array(16), Field(min_length=16, max_length=16)] = Field(
        default_factory=lambda: [0] * 16
    )
    sequence_number: Int64 = 0
