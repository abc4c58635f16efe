"""Times and durations."""

from __future__ import annotations

from hmrsim.interfaces.message import Int32, Message, UInt32

_NANOSECONDS = 1_000_000_000


class Time(Message):
    """A point in simulated time: whole seconds and nanoseconds since its start."""

    sec: Int32 = 0
    nanosec: UInt32 = 0

    @classmethod
    def from_nanoseconds(cls, nanoseconds: int) -> Time:
        """Return the time that is *nanoseconds* after zero."""
        sec, nanosec = divmod(nanoseconds, _NANOSECONDS)
        return cls(sec=sec, nanosec=nanosec)

    def to_nanoseconds(self) -> int:
        """Return the whole nanoseconds since zero."""
        return self.sec * _NANOSECONDS + self.nanosec


class Duration(Message):
    """A span of time in seconds and nanoseconds; a negative one has a negative *sec*."""

    sec: Int32 = 0
    nanosec: UInt32 = 0

    @classmethod
    def from_seconds(cls, seconds: float) -> Duration:
        """Return the duration of *seconds*, rounded to whole nanoseconds."""
        sec, nanosec = divmod(round(seconds * _NANOSECONDS), _NANOSECONDS)
        return cls(sec=sec, nanosec=nanosec)

    def to_seconds(self) -> float:
        """Return the span in seconds."""
        return self.sec + self.nanosec / _NANOSECONDS
