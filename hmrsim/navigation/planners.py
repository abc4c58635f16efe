"""The planners of a map where some ways count for longer, one for each set of closed lanes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.navigation.durations import Durations
from hmrsim.navigation.kept import Kept
from hmrsim.navigation.planner import Planner

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hmrsim.navigation.lanes import Lanes

_KEPT_PLANNERS = 16
"""Planners that are kept, one for each set of lanes to avoid; the least recently used one is dropped."""

Lane = tuple[str, str]
"""A lane in one direction, by the waypoints where it begins and ends."""


class Planners:
    """Planners on the lanes of a map.

    Args:
        lanes: The lanes.
        avoided: The numbers of ways that count for longer.
        factor: How many times as long these count for.

    Attributes:
        durations: How long each way counts for.
    """

    def __init__(self, lanes: Lanes, avoided: Sequence[int] = (), factor: float = 1.0) -> None:
        self._lanes = lanes
        self.durations = Durations(lanes.ways, avoided, factor)
        self._kept: Kept[frozenset[Lane], Planner] = Kept(_KEPT_PLANNERS)

    def without(self, closed: frozenset[Lane]) -> Planner:
        """Return the planner that takes none of some lanes."""
        return self._kept.get(closed, lambda: self._planner(closed))

    def _planner(self, closed: frozenset[Lane]) -> Planner:
        numbers = self._lanes.numbers
        return Planner(self._lanes, self.durations, {numbers[lane] for lane in closed if lane in numbers})
