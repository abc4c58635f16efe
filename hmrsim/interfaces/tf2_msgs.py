"""The transforms between coordinate frames."""

from __future__ import annotations

from pydantic import Field

from hmrsim.interfaces.geometry_msgs import TransformStamped
from hmrsim.interfaces.message import Message


class TFMessage(Message):
    """Part of the tree of frames."""

    transforms: list[TransformStamped] = Field(default_factory=list)
