"""The lanes and rides of a world in each direction, and the same as a graph of networkx.

The simulator plans on faster lists of the same lanes (`hmrsim.navigation.lanes`). networkx is imported only when the
graph is used, because it takes a third of the time and memory that a simulator needs to start.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from hmrsim.geometry import distance

if TYPE_CHECKING:
    import networkx as nx

    from hmrsim.geometry import Point


@dataclass(frozen=True, slots=True)
class Way:
    """A lane in one direction, or a ride in a lift.

    Attributes:
        start: Name of the waypoint where it begins.
        end: Name of the waypoint where it ends.
        length: In the world's unit.
        speed_limit: Maximum speed; infinite without a limit.
        capacity: How many robots may be on it at once; None for any number.
        ride: Seconds that the lift takes; 0 for a lane.
        lift: Name of the lift; None for a lane.
        one_way: Whether it belongs to a lane that can't be driven in the other direction.
    """

    start: str
    end: str
    length: float
    speed_limit: float
    capacity: int | None
    ride: float = 0.0
    lift: str | None = None
    one_way: bool = False

    def seconds(self, speed: float) -> float:
        """Return how long a robot with this maximum speed takes, in seconds, without acceleration."""
        return self.ride or self.length / min(speed, self.speed_limit)


def as_networkx(
    about: Mapping[str, Any],
    nodes: Mapping[str, Mapping[str, Any]],
    ways: Iterable[Way],
    doors: Mapping[frozenset[str], tuple[str, ...]],
    locked: frozenset[str],
) -> nx.DiGraph[str]:
    """Return a frozen graph; `World.graph` documents its attributes.

    Args:
        about: Attributes of the graph; ``speed`` is the one that costs are for.
        nodes: Attributes of the waypoints, by name.
        ways: The edges of the graph.
        doors: The doors that a lane crosses, by the names of its ends; none where a lane is missing.
        locked: The doors that open for no robot.
    """
    import networkx as nx  # noqa: PLC0415 - see above

    graph: nx.DiGraph[str] = nx.DiGraph(**about)
    graph.add_nodes_from((name, dict(values)) for name, values in nodes.items())
    for way in ways:
        crossed = () if way.lift else doors.get(frozenset((way.start, way.end)), ())
        graph.add_edge(
            way.start,
            way.end,
            length=way.length,
            speed_limit=way.speed_limit,
            cost=way.seconds(about["speed"]),
            capacity=way.capacity,
            one_way=way.one_way,
            lift=way.lift,
            ride=way.ride,
            doors=crossed,
            closed=not locked.isdisjoint(crossed),
        )
    frozen: nx.DiGraph[str] = nx.freeze(graph)
    return frozen


def levels(waypoints: Iterable[str], ways: Iterable[Way], lifts: Mapping[str, tuple[str, ...]]) -> dict[str, int]:
    """Return the level of each waypoint: lifts lead from one to the next, and lanes stay on theirs.

    The lowest level that lifts connect is 0. Waypoints that no lift leads to are on level 0, too.
    """
    found = dict.fromkeys(waypoints, 0)
    beside: dict[str, list[str]] = {name: [] for name in found}
    for way in ways if lifts else ():
        if not way.lift:
            beside[way.start].append(way.end)
            beside[way.end].append(way.start)
    waiting = dict(lifts)
    while waiting:
        joined: dict[str, int] = {}
        lift: str | None = next(iter(waiting))
        while lift is not None:
            stops = waiting.pop(lift)
            lowest = next((joined[stop] - number for number, stop in enumerate(stops) if stop in joined), 0)
            for number, stop in enumerate(stops):
                _spread(joined, beside, stop, lowest + number)
            lift = next((name for name, stops in waiting.items() if not joined.keys().isdisjoint(stops)), None)
        least = min(joined.values())
        found |= {name: level - least for name, level in joined.items()}
    return found


def _spread(joined: dict[str, int], beside: Mapping[str, list[str]], stop: str, level: int) -> None:
    """Give a level to a stop and to the waypoints connected to it by lanes; a waypoint that has one keeps it."""
    reached = [stop]
    while reached:
        here = reached.pop()
        if here not in joined:
            joined[here] = level
            reached += beside[here]


def nearest(waypoints: Mapping[str, Point], points: Mapping[str, Point]) -> dict[str, str]:
    """Return the waypoint that is nearest to each point, in a straight line; of equally near ones the first by name.

    There must be one waypoint at least.
    """
    by_x = sorted((point[0], name, point) for name, point in waypoints.items())
    return {name: _nearest(by_x, point) for name, point in points.items()}


def _nearest(by_x: list[tuple[float, str, Point]], point: Point) -> str:
    right = bisect_left(by_x, (point[0],))
    left = right - 1
    best: tuple[float, str] | None = None
    while left >= 0 or right < len(by_x):
        gap_left = point[0] - by_x[left][0] if left >= 0 else float("inf")
        gap_right = by_x[right][0] - point[0] if right < len(by_x) else float("inf")
        if best is not None and min(gap_left, gap_right) > best[0]:
            break
        _, name, at = by_x[left if gap_left <= gap_right else right]
        left, right = (left - 1, right) if gap_left <= gap_right else (left, right + 1)
        found = distance(point, at), name
        best = found if best is None else min(best, found)
    if best is None:
        raise ValueError("there is no waypoint")
    return best[1]
