"""Simulated time in whole nanoseconds, as ROS states it."""

from __future__ import annotations


def nanoseconds(seconds: float) -> int:
    """Return simulated seconds as whole nanoseconds."""
    return round(seconds * 1_000_000_000)


def stamp(seconds: float) -> int:
    """Return the stamp of what happens at this time: its nanoseconds, but never zero, which ROS reads as "unset"."""
    return max(1, nanoseconds(seconds))
