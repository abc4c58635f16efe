"""Points in time and durations."""

from __future__ import annotations

from hmrsim.interfaces.message import Int32, Message, UInt32

NANOSECONDS = 1_000_000_000
"""Nanoseconds in a second."""

MAX_NANOSECONDS = 2**31 * NANOSECONDS - 1
"""The most nanoseconds that ROS can express: 68 years. Longer times are capped to it."""


def values_of(nanoseconds: float) -> dict[str, int]:
    """Return nanoseconds as the plain values of a `Time` or `Duration`, capped to what ROS can express."""
    if not -MAX_NANOSECONDS < nanoseconds < MAX_NANOSECONDS:
        nanoseconds = max(-MAX_NANOSECONDS, min(MAX_NANOSECONDS, nanoseconds))
    sec, nanosec = divmod(round(nanoseconds), NANOSECONDS)
    return {"sec": sec, "nanosec": nanosec}


class Time(Message):
    """A point in simulated time: whole seconds and nanoseconds since its start."""

    sec: Int32 = 0
    nanosec: UInt32 = 0

    @classmethod
    def from_nanoseconds(cls, nanoseconds: int) -> Time:
        """Return the time that is *nanoseconds* after zero, capped to what ROS can express."""
        return cls(**values_of(nanoseconds))

    def to_nanoseconds(self) -> int:
        """Return the whole nanoseconds since zero."""
        return self.sec * NANOSECONDS + self.nanosec


class Duration(Message):
    """A span of time in seconds and nanoseconds; a negative one has a negative *sec*."""

    sec: Int32 = 0
    nanosec: UInt32 = 0

    @classmethod
    def from_seconds(cls, seconds: float) -> Duration:
        """Return the duration of *seconds* in whole nanoseconds, capped to what ROS can express."""
        return cls(**values_of(seconds * NANOSECONDS))

    def to_seconds(self) -> float:
        """Return the span in seconds."""
        return self.sec + self.nanosec / NANOSECONDS
