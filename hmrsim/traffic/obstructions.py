"""Obstructions: robots and items on lanes, up to which vehicles drive, and no farther."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from typing import TYPE_CHECKING

from hmrsim.errors import NoRoute
from hmrsim.geometry import SAME_PLACE, distance

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.navigation.graph import Lane
    from hmrsim.navigation.lanes import Lanes
    from hmrsim.navigation.route import Leg, Route


class Obstructions:
    """The places of obstructions, by the cause for which their lanes are closed."""

    def __init__(self, lanes: Lanes) -> None:
        self._lanes = lanes
        self._points: dict[str, Point] = {}

    def add(self, cause: str, point: Point) -> list[Lane]:
        """Add one; return its lane, in each direction; none at a waypoint, where vehicles get past."""
        if point in self._lanes.at:
            return []
        on_lane, feet = self._lanes.feet(point)
        if not on_lane:
            return []
        self._points[cause] = point
        return [edge.leg.lane for edge, _ in feet if edge.leg.lane]

    def remove(self, cause: str) -> bool:
        """Remove one; return whether it was there."""
        return self._points.pop(cause, None) is not None

    def __contains__(self, cause: str) -> bool:
        """Return whether something is in the way."""
        return cause in self._points

    def let_drive(self, leg: Leg, causes: Collection[str]) -> bool:
        """Return whether a leg on a lane that is closed for these causes ends before all obstructions there."""
        return all(cause in self._points and not _passes(leg, self._points[cause]) for cause in causes)

    def up_to(
        self, goal: Point, closed: Mapping[Lane, Collection[str]], plan: Callable[[Point], Route]
    ) -> Route | None:
        """Return the shortest route to a point of a closed lane, from the end from which it can be reached.

        *plan* plans the route to an end; it raises `NoRoute` as planners do.

        Returns:
            The route; None if there is none.
        """
        if not self._points or goal in self._lanes.at:
            return None
        on_lane, feet = self._lanes.feet(goal)
        routes = []
        for edge, _ in feet if on_lane else ():
            leg = self._lanes.part(edge, edge.leg.start, goal)
            if edge.leg.lane is not None and edge.leg.lane in closed and self.let_drive(leg, closed[edge.leg.lane]):
                with suppress(NoRoute):
                    routes.append(self._lanes.route([*plan(leg.start).legs, leg], goal))
        return min(routes, key=lambda route: sum(leg.length for leg in route.legs), default=None)


def _passes(leg: Leg, point: Point) -> bool:
    """Return whether a leg on a lane leads beyond a point of that lane."""
    before, behind = distance(leg.start, point), distance(point, leg.end)
    return SAME_PLACE < before < leg.length and SAME_PLACE < behind < leg.length
