"""Closed lanes, each with the reasons for its closure, and the obstructions that close them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING

from hmrsim.errors import NoRoute
from hmrsim.events.traffic import LaneClosed, LaneOpened
from hmrsim.geometry import SAME_PLACE, distance

if TYPE_CHECKING:
    from hmrsim.engine.subscriptions import EventPublisher
    from hmrsim.geometry import Point
    from hmrsim.navigation.graph import Lane, WaypointGraph
    from hmrsim.navigation.lanes import Lanes
    from hmrsim.navigation.route import Leg, Route


class LaneClosures:
    """The closed lanes of one world; a lane may be closed for several causes.

    Args:
        graph: Its lanes, which routes use unless they are closed.
        follow: Called when lanes have been closed or opened.
        changed: Likewise, once changes are published.

    Attributes:
        lanes: Why each closed lane is closed, in words, by cause.
        obstructions: The items and robots that block lanes.
    """

    def __init__(
        self,
        graph: WaypointGraph,
        publisher: EventPublisher,
        follow: Callable[[], None],
        changed: Callable[[], None],
    ) -> None:
        self.lanes: dict[Lane, dict[str, str]] = {}
        self.obstructions = Obstructions(graph.lanes)
        self._graph = graph
        self._publisher = publisher
        self._follow = follow
        self._changed = changed
        self._published = False

    def publish(self) -> None:
        """Publish changes from now on: the lanes that the world's fixtures close at its start are no change."""
        self._published = True

    def close(self, lanes: Iterable[Lane], cause: str, why: str) -> None:
        """Close lanes to vehicles that are not on them, for a *cause* by which they can be opened again."""
        for lane in lanes:
            self.lanes.setdefault(lane, {})[cause] = why
        self._update()

    def open(self, cause: str) -> None:
        """Open the lanes that were closed for a *cause*, unless another cause keeps them closed."""
        fewer = [lane for lane, causes in self.lanes.items() if cause in causes] if self.lanes else []
        if not fewer:
            return
        for lane in fewer:
            del self.lanes[lane][cause]
            if not self.lanes[lane]:
                del self.lanes[lane]
        self._update()
        if any(lane in self.lanes for lane in fewer):
            # The causes that are left may let a vehicle drive a part of the lane.
            self._follow()

    def obstruct(self, name: str, point: Point, why: str) -> None:
        """Close the lane, in both directions, on which something is that no vehicle gets past; a waypoint has room."""
        cause = _cause(name)
        lanes = self.obstructions.add(cause, point)
        if lanes:
            self.close(lanes, cause, why)

    def is_obstructed_by(self, name: str) -> bool:
        """Return whether something is in the way on a lane."""
        return _cause(name) in self.obstructions

    def is_closed_by(self, lane: Lane | None, name: str) -> bool:
        """Return whether a lane is closed as something is in the way there."""
        return lane is not None and _cause(name) in self.lanes.get(lane, ())

    def clear(self, name: str) -> None:
        """Open the lanes on which something was in the way; nothing happens if it was not."""
        cause = _cause(name)
        if self.obstructions.remove(cause):
            self.open(cause)

    def why(self, leg: Leg) -> str:
        """Return why a leg can't be begun now, or ""; a vehicle on a closed lane may leave it."""
        lane = leg.lane
        if lane is None or lane not in self.lanes or leg.start != self._graph.waypoints[lane[0]]:
            return ""
        if self.obstructions.let_drive(leg, self.lanes[lane]):
            return ""
        return f"{lane[0]}-{lane[1]} is closed: {'; '.join(self.lanes[lane].values())}"

    def descriptions(self) -> list[str]:
        """Return which lanes are closed, and why, in words; both directions as one if the reason is the same."""
        told: dict[tuple[str, str], str] = {}
        for (a, b), causes in self.lanes.items():
            why = "; ".join(causes.values())
            if told.get((b, a)) != why:
                told[a, b] = why
        return [f"{a}-{b} is closed ({why})" for (a, b), why in told.items()]

    def _update(self) -> None:
        before, now = self._graph.closed, frozenset(self.lanes)
        if before == now:
            return
        self._graph.closed = now
        if self._published:
            for lane in sorted(now - before):
                self._publisher.publish(partial(LaneClosed, lane, "; ".join(self.lanes[lane].values())))
            for lane in sorted(before - now):
                self._publisher.publish(partial(LaneOpened, lane))
            self._changed()
        self._follow()


def _cause(name: str) -> str:
    """Return the cause of lanes that are closed as something is in the way there."""
    return f"{name} in the way"


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
