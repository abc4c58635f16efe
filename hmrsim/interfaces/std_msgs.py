"""Headers and other standard messages."""

from __future__ import annotations

from pydantic import Field

from hmrsim.interfaces.builtin_interfaces import Time
from hmrsim.interfaces.message import Float32, Message
from hmrsim.interfaces.message import String as Text


class Header(Message):
    """The frame and time of a message's data; an empty frame is ``map``."""

    stamp: Time = Field(default_factory=Time)
    frame_id: Text = ""


class Empty(Message):
    """A message without any fields."""


class String(Message):
    """A message that holds only a text."""

    data: Text = ""


class ColorRGBA(Message):
    """A color; each part is from 0 to 1."""

    r: Float32 = 0.0
    g: Float32 = 0.0
    b: Float32 = 0.0
    a: Float32 = 0.0
