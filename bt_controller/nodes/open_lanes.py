"""Detection of closed lanes on a path: the simulator's open lanes are compared with those of earlier queries.

A path is closed where it enters a lane that was open earlier and is not open now. A robot on such a lane may leave it.
A segment that has never been a lane counts as open: the planner has considered the walls, which do not move.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from bt_controller.nodes.paths import point_of
from hmrsim.geometry import SAME_PLACE, Point, distance, foot
from hmrsim_zenoh.wire.descriptions import plain_values
from hmrsim_zenoh.wire.envelopes import UnreadableError

if TYPE_CHECKING:
    from hmrsim.interfaces.nav_msgs import Path
    from hmrsim_zenoh.client.client import Client

Way = tuple[Point, Point]
"""A lane in its direction of travel."""


class OpenLanes:
    """The lanes that are open now, and those that were open earlier.

    Raises:
        SimulatorNotFound, SimulatorGone, Unreachable, RequestError, RequestTimeout: The simulator does not answer.
    """

    def __init__(self, client: Client) -> None:
        self._client = client
        self._received = b""
        self._open: frozenset[Way] = frozenset()
        self._known: frozenset[Way] = frozenset()
        self.look()

    def look(self) -> None:
        """Query the open lanes.

        Raises:
            SimulatorNotFound, SimulatorGone, Unreachable, RequestError, RequestTimeout: The simulator does not answer.
        """
        received = self._client.get(self._client.keys.world("route_graph"))
        if received != self._received:
            self._received, self._open = received, _open_ways(received)
            self._known |= self._open

    def closed_legs(self, path: Path) -> list[int]:
        """Return the indices of the poses after which a path enters a closed lane."""
        closed = sorted(self._known - self._open)
        legs = [(point_of(a), point_of(b)) for a, b in pairwise(path.poses)]
        # The closed lane on which the path begins may be left; None after that.
        leaving = next((way for way in closed if legs and _is_on(legs[0], way) and not _is_begun(legs[0], way)), None)
        found = []
        for index, leg in enumerate(legs):
            if leaving is not None and not _is_on(leg, leaving):
                leaving = None
            if any(way != leaving and (_is_on(leg, way) or _is_on(way, leg)) for way in closed):
                found.append(index)
        return found


def _open_ways(received: bytes) -> frozenset[Way]:
    """Return the lanes of a route graph as it was received.

    Raises:
        UnreadableError: It is none.
    """
    graph = plain_values("the route graph", received)
    try:
        return frozenset(_ways(graph))
    except (LookupError, TypeError):
        raise UnreadableError("the route graph is not in Nav2's GeoJSON format") from None


def _ways(graph: Any) -> Iterator[Way]:
    """Yield the lanes of a route graph in Nav2's GeoJSON format."""
    for feature in graph["features"]:
        match feature["geometry"]:
            case {"type": "LineString", "coordinates": [first, *_, last]}:
                yield (first[0], first[1]), (last[0], last[1])
            case {"type": "MultiLineString", "coordinates": [[first, *_], *_] as lines}:
                yield (first[0], first[1]), (lines[-1][-1][0], lines[-1][-1][1])


def _is_on(leg: Way, way: Way) -> bool:
    """Return whether a leg lies on a straight lane in the same direction."""
    (a, b), (start, end) = leg, way
    along = (b[0] - a[0]) * (end[0] - start[0]) + (b[1] - a[1]) * (end[1] - start[1])
    return along > 0.0 and all(distance(point, foot(point, start, end)) <= SAME_PLACE for point in leg)


def _is_begun(leg: Way, way: Way) -> bool:
    """Return whether a leg begins at the begin of a lane."""
    return distance(leg[0], way[0]) <= SAME_PLACE
