"""Closed lanes, each with the reasons for its closure, and barriers on lanes, such as doors."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING, Protocol

from hmrsim.errors import NoRoute
from hmrsim.events.traffic import LaneClosed, LaneOpened
from hmrsim.geometry import SAME_PLACE, distance

if TYPE_CHECKING:
    from hmrsim.engine.subscriptions import EventPublisher
    from hmrsim.geometry import Point
    from hmrsim.navigation.graph import Lane, WaypointGraph
    from hmrsim.navigation.lanes import Lanes
    from hmrsim.navigation.route import Leg, Route
    from hmrsim.traffic.rules import Vehicle


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


class Barrier(Protocol):
    """A fixture on lanes that may have to open first, such as a door."""

    @property
    def lanes(self) -> Collection[Lane]:
        """The lanes that lead through it, in each direction in which they can be driven."""

    @property
    def refuses(self) -> bool:
        """Return whether the barrier may refuse a vehicle for good."""

    def may_pass(self, robot: Vehicle) -> bool:
        """Return whether it ever lets a vehicle pass; if not, routes avoid it."""

    def why_not(self, robot: Vehicle, leg: Leg) -> str:
        """Return why a vehicle can't begin a leg now, or ""; off the lanes the leg may be nowhere near.

        A barrier that opens for the vehicle begins to, and has vehicles look again when it is open.
        """

    def summon(self, leg: Leg) -> None:
        """Come for a vehicle that is to be moved along a leg, and does not wait for it."""

    def enter(self, robot: Vehicle, leg: Leg) -> None:
        """Record that a vehicle begins to drive through."""

    def leave(self, robot: Vehicle) -> None:
        """Record that a vehicle has driven through or has stopped on its leg."""


class Barriers:
    """The barriers of one world; each is asked on its lanes, and where a vehicle leaves the lanes, too.

    Attributes:
        on_lanes: Those on each lane that has any. To be read only, as it is for each lane that is driven.
        inside: Those through which vehicles drive now. To be read only, too.
    """

    def __init__(self) -> None:
        self._all: list[Barrier] = []
        self.on_lanes: dict[Lane, list[Barrier]] = {}
        # Most barriers are for every vehicle.
        self._refusing: dict[Lane, list[Barrier]] = {}
        self._kept_off: dict[Vehicle, dict[Lane, None]] = {}
        self.inside: dict[Vehicle, list[Barrier]] = {}

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self._all)

    def add(self, barrier: Barrier) -> None:
        """Add one, with its lanes."""
        self._all.append(barrier)
        for lane in barrier.lanes:
            self.on_lanes.setdefault(lane, []).append(barrier)
            if barrier.refuses:
                self._refusing.setdefault(lane, []).append(barrier)
        self._kept_off.clear()

    def changed(self, lanes: Iterable[Lane]) -> None:
        """Record that a barrier on these lanes has changed."""
        if self._kept_off and not self._refusing.keys().isdisjoint(lanes):
            self._kept_off.clear()

    def kept_off(self, robot: Vehicle) -> Collection[Lane]:
        """Return the lanes that a vehicle can never pass, in order."""
        if not self._refusing:
            return ()
        known = self._kept_off.get(robot)
        if known is None:
            lanes = [(lane, self._refusing[lane]) for lane in self.on_lanes if lane in self._refusing]
            known = {lane: None for lane, barriers in lanes if not all(each.may_pass(robot) for each in barriers)}
            self._kept_off[robot] = known
        return known

    def may_pass(self, robot: Vehicle, lane: Lane) -> bool:
        """Return whether a vehicle can ever pass a lane."""
        return lane not in self._refusing or lane not in self.kept_off(robot)

    def why_not(self, robot: Vehicle, leg: Leg) -> str:
        """Return why a vehicle can't begin a leg now, or ""; it does not join a lane to stop in the middle of it."""
        first, lane = "", leg.lane
        for barrier in self._all if lane is None else self.on_lanes.get(lane, ()):
            # Each is asked, so that each begins to open.
            why = barrier.why_not(robot, leg)
            first = first or why
        ahead = leg.joins
        if ahead is not None and ahead.lane and self.may_pass(robot, ahead.lane):
            why = self.why_not(robot, ahead)
            first = first or why
        return first

    def summon(self, leg: Leg) -> None:
        """Call the barriers on a leg for a vehicle that is going to drive it."""
        for barrier in self.on_lanes.get(leg.lane, ()) if leg.lane else ():
            barrier.summon(leg)

    def enter(self, robot: Vehicle, leg: Leg) -> None:
        """Record that a vehicle begins a leg, and has left the barriers of the one before."""
        if robot in self.inside:
            self.leave(robot)
        lane = leg.leads_onto
        if lane in self.on_lanes:
            barriers = self.inside[robot] = [*self.on_lanes[lane]]
            for barrier in barriers:
                barrier.enter(robot, leg)

    def leave(self, robot: Vehicle) -> None:
        """Record that a vehicle has reached the end of its leg or has stopped on it."""
        for barrier in self.inside.pop(robot, ()):
            barrier.leave(robot)
