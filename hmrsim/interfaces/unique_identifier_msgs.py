"""The identifiers that goals carry."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from hmrsim.interfaces.message import Array, Message, UInt8


class UUID(Message):
    """A universally unique identifier, as 16 bytes."""

    uuid: Annotated[list[UInt8], Array(16), Field(min_length=16, max_length=16)] = Field(
        default_factory=lambda: [0] * 16
    )
