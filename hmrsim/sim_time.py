"""Simulated time in whole nanoseconds, as ROS states it."""

from __future__ import annotations

_MOST = 2**31 * 1_000_000_000 - 1
"""The latest time that ROS can state, 68 years: what happens later is stamped so."""


def nanoseconds(seconds: float) -> int:
    """Return simulated seconds as whole nanoseconds."""
    return round(min(seconds * 1_000_000_000, _MOST))


def stamp(seconds: float) -> int:
    """Return the stamp of what happens at this time: its nanoseconds, but never zero, which ROS reads as "unset"."""
    return max(1, nanoseconds(seconds))
