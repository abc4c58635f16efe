"""How long ways are, for features: on all lanes of the map, whatever is closed at the moment."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Final

from hmrsim.errors import NoRoute
from hmrsim.geometry import distance
from hmrsim.navigation.graph import WaypointGraph

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.world.model import World

_KEPT: Final = 65_536
"""Pairs of points whose distance is kept."""


class Routes:
    """The ways of a world. It has a graph of its own, so that what it tells depends on the map only."""

    def __init__(self, world: World) -> None:
        self._graph = WaypointGraph(world)
        self.seconds = lru_cache(_KEPT)(self._seconds)
        """Return how long the quickest route takes at a speed; where there is none, the straight way."""

    def _seconds(self, start: Point, goal: Point, speed: float) -> float:
        try:
            return self._graph.plan(start, goal, speed).length / speed
        except NoRoute:
            return distance(start, goal) / speed
