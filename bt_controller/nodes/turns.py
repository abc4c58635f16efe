"""The limit of repetitions at one instant, so that simulated time can go on."""

from __future__ import annotations

import math
from typing import Final

from bt_controller.core.sim_time import now

MAX_TURNS: Final = 1000
"""Turns in one tick, and at one instant."""


class TurnCounter:
    """Counts turns at one instant."""

    def __init__(self) -> None:
        self._at = -math.inf
        self._taken = 0

    def take(self) -> bool:
        """Return whether there is another turn now; after a thousand at one instant, when time has gone on."""
        if now() != self._at:
            self._at, self._taken = now(), 0
        self._taken += 1
        return self._taken <= MAX_TURNS
