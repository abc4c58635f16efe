"""The one place where the simulator reads a wall clock."""

from __future__ import annotations

import time


def wall_time() -> float:
    """Return wall seconds since some moment in the past."""
    return time.monotonic()
