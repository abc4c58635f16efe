"""The message of the simulation's clock."""

from __future__ import annotations

from pydantic import Field

from hmrsim.interfaces.builtin_interfaces import Time
from hmrsim.interfaces.message import Message


class Clock(Message):
    """The current simulated time, from the start."""

    clock: Time = Field(default_factory=Time)
