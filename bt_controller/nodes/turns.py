"""The limit of repetitions at one instant, so that simulated time can advance."""

from __future__ import annotations

import math
from typing import Final

from bt_controller.core.sim_time import now

MAX_TURNS: Final = 1000
"""The largest number of repetitions in one tick, and at one instant."""


class TurnCounter:
    """Counts repetitions at one instant."""

    def __init__(self) -> None:
        self._at = -math.inf
        self._count = 0

    def count(self) -> bool:
        """Count a repetition; return whether it is allowed, which after a thousand it is when time has advanced."""
        if now() != self._at:
            self._at, self._count = now(), 0
        self._count += 1
        return self._count <= MAX_TURNS
