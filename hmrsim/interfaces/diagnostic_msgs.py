"""The condition of hardware, as diagnostic tools show it."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from hmrsim.interfaces.message import Byte, Message, String
from hmrsim.interfaces.std_msgs import Header


class KeyValue(Message):
    """A named value, as text."""

    key: String = ""
    value: String = ""


class DiagnosticStatus(Message):
    """The condition of one part."""

    OK: ClassVar[int] = 0
    WARN: ClassVar[int] = 1
    ERROR: ClassVar[int] = 2
    STALE: ClassVar[int] = 3

    level: Byte = 0
    name: String = ""
    message: String = ""
    hardware_id: String = ""
    values: list[KeyValue] = Field(default_factory=list)


class DiagnosticArray(Message):
    """The conditions of several parts at one time."""

    header: Header = Field(default_factory=Header)
    status: list[DiagnosticStatus] = Field(default_factory=list)
