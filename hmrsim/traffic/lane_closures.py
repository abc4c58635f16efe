"""Lanes that nobody may enter now, and why."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from hmrsim.events.traffic import LaneClosed, LaneOpened
from hmrsim.traffic.obstructions import Obstructions

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from hmrsim.engine.subscriptions import Happenings
    from hmrsim.geometry import Point
    from hmrsim.navigation.graph import Lane, WaypointGraph
    from hmrsim.navigation.route import Leg


class Closures:
    """The closed lanes of one world; a lane may be closed for several causes.

    Args:
        graph: Its ways, of which closed lanes are no part.
        happened: Tells of lanes that are closed and opened.
        follow: Called when some have been.

    Attributes:
        lanes: Why each closed lane is, by cause, for people.
        obstructions: What stands or lies on lanes.
        changed: Called when lanes have been closed or opened. None while all is being put in its place: then it is no
            news which are closed.
    """

    def __init__(self, graph: WaypointGraph, happened: Happenings, follow: Callable[[], None]) -> None:
        self.lanes: dict[Lane, dict[str, str]] = {}
        self.obstructions = Obstructions(graph.lanes)
        self.changed: Callable[[], None] | None = None
        self._graph = graph
        self._happened = happened
        self._follow = follow

    def close(self, lanes: Iterable[Lane], cause: str, why: str) -> None:
        """Let nobody enter some lanes, because of a *cause* by which they can be opened again; who is there goes on."""
        for lane in lanes:
            self.lanes.setdefault(lane, {})[cause] = why
        self._update()

    def open(self, cause: str) -> None:
        """Open the lanes again that were closed because of a *cause*, if nothing else keeps them closed."""
        fewer = [lane for lane, causes in self.lanes.items() if cause in causes]
        for lane in fewer:
            del self.lanes[lane][cause]
            if not self.lanes[lane]:
                del self.lanes[lane]
        self._update()
        if any(lane in self.lanes for lane in fewer):
            # What keeps it closed still may let somebody go a part of the way.
            self._follow()

    def obstruct(self, name: str, point: Point, why: str) -> None:
        """Close the lane, both ways, on which something stands or lies that nobody gets past; a waypoint has room."""
        cause = _cause(name)
        lanes = self.obstructions.add(cause, point)
        if lanes:
            self.close(lanes, cause, why)

    def is_obstructed_by(self, name: str) -> bool:
        """Return whether something is in the way on a lane."""
        return _cause(name) in self.obstructions

    def clear(self, name: str) -> None:
        """Open the lanes again on which something was in the way; nothing happens if it was not."""
        cause = _cause(name)
        if self.obstructions.remove(cause):
            self.open(cause)

    def why(self, leg: Leg) -> str:
        """Return why nobody may begin a leg now, or ""; who is on a closed lane may leave it."""
        lane = leg.lane
        if lane is None or lane not in self.lanes or leg.start != self._graph.waypoints[lane[0]]:
            return ""
        if self.obstructions.let_drive(leg, self.lanes[lane]):
            return ""
        return f"{lane[0]}-{lane[1]} is closed: {'; '.join(self.lanes[lane].values())}"

    def told(self) -> list[str]:
        """Return which lanes are closed, and why, for people."""
        return [f"{a}-{b} is closed ({'; '.join(why.values())})" for (a, b), why in self.lanes.items()]

    def _update(self) -> None:
        before, now = self._graph.closed, frozenset(self.lanes)
        if before == now:
            return
        self._graph.closed = now
        if self.changed is not None:
            for lane in sorted(now - before):
                self._happened.publish(partial(LaneClosed, lane, "; ".join(self.lanes[lane].values())))
            for lane in sorted(before - now):
                self._happened.publish(partial(LaneOpened, lane))
            self.changed()
        self._follow()


def _cause(name: str) -> str:
    return f"{name} in the way"
