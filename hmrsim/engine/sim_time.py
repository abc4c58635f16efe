"""Simulated time in whole nanoseconds, as ROS states it, and the one place where the simulator reads a wall clock."""

from __future__ import annotations

import time
from typing import Final

from hmrsim.interfaces.builtin_interfaces import MAX_NANOSECONDS, NANOSECONDS

JITTER = 1_000_000
"""Nanoseconds by which a received time may be earlier than the one before, without a reset of time."""


def nanoseconds(seconds: float) -> int:
    """Return simulated seconds as whole nanoseconds, or the latest time that ROS can state."""
    return round(min(seconds * NANOSECONDS, MAX_NANOSECONDS))


def stamp(seconds: float) -> int:
    """Return the stamp of an event at this time: its nanoseconds, but never zero, which ROS reads as "unset"."""
    exact = seconds * NANOSECONDS
    return round(exact) if 1.0 <= exact <= MAX_NANOSECONDS else max(1, nanoseconds(seconds))


def end_of_instant(seconds: float) -> float:
    """Return the end of an instant: events that are due in the same nanosecond happen at the same time.

    The first instant is the first two nanoseconds, as both have the same stamp.
    """
    # As `stamp`, whose call would cost as much as the rest.
    exact = seconds * NANOSECONDS
    number = round(exact) if 1.0 <= exact <= MAX_NANOSECONDS else stamp(seconds)
    return max(seconds, (number + 0.5) / NANOSECONDS)


wall_time: Final = time.monotonic
"""Returns wall seconds since some moment in the past."""
