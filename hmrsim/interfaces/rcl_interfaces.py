"""What nodes log."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from hmrsim.interfaces.builtin_interfaces import Time
from hmrsim.interfaces.message import Message, String, UInt8, UInt32


class Log(Message):
    """A line of a node's log: time, severity, logger, text, and the place in the source."""

    DEBUG: ClassVar[int] = 10
    INFO: ClassVar[int] = 20
    WARN: ClassVar[int] = 30
    ERROR: ClassVar[int] = 40
    FATAL: ClassVar[int] = 50

    stamp: Time = Field(default_factory=Time)
    level: UInt8 = 0
    name: String = ""
    msg: String = ""
    file: String = ""
    function: String = ""
    line: UInt32 = 0
