"""The road network of a world: its lanes and lift rides in each direction, also as a networkx graph.

The simulator itself plans on `hmrsim.navigation.lanes`, which is faster. networkx is imported only when the graph is
used, because it would take a third of the simulator's startup time and memory.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from hmrsim.geometry import distance

if TYPE_CHECKING:
    from array import array

    import networkx as nx

    from hmrsim.geometry import Point


@dataclass(frozen=True, slots=True)
class Way:
    """A lane in one direction, or a ride in a lift.

    Attributes:
        start: Name of the waypoint at its start.
        end: Name of the waypoint at its end.
        length: In the world's unit.
        speed_limit: Maximum speed; infinite without a limit.
        capacity: How many robots may be on it at once; None for any number.
        ride: Seconds that the lift takes; 0 for a lane.
        lift: Name of the lift; None for a lane.
        one_way: Whether it is a lane without an opposite direction.
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
        """Return the travel time in seconds at this maximum speed, without acceleration."""
        return self.ride or self.length / min(speed, self.speed_limit)


def as_networkx(
    about: Mapping[str, Any],
    nodes: Mapping[str, Mapping[str, Any]],
    ways: Iterable[Way],
    doors: Mapping[frozenset[str], tuple[str, ...]],
    locked: frozenset[str],
) -> nx.DiGraph[str]:
    """Return a frozen networkx graph; `World.graph` documents its attributes.

    Args:
        about: Attributes of the graph; its ``speed`` determines the costs.
        nodes: Attributes of the waypoints, by name.
        ways: The edges of the graph.
        doors: The doors that a lane crosses, by the names of its ends; lanes without doors may be missing.
        locked: The closed doors that open for no robot.
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
    """Return the level of each waypoint: a lift goes up one level from stop to stop, and lanes stay on a level.

    The lowest level that lifts connect is 0; waypoints that no lift leads to are also at level 0.
    """
    result = dict.fromkeys(waypoints, 0)
    neighbors: dict[str, list[str]] = {name: [] for name in result}
    for way in ways if lifts else ():
        if not way.lift:
            neighbors[way.start].append(way.end)
            neighbors[way.end].append(way.start)
    remaining = dict(lifts)
    while remaining:
        # One building: the lifts that share levels, relative to the first stop of the first of them.
        building: dict[str, int] = {}
        lift: str | None = next(iter(remaining))
        while lift is not None:
            stops = remaining.pop(lift)
            lowest = next((building[stop] - number for number, stop in enumerate(stops) if stop in building), 0)
            for number, stop in enumerate(stops):
                _spread(building, neighbors, stop, lowest + number)
            lift = next((name for name, stops in remaining.items() if not building.keys().isdisjoint(stops)), None)
        ground = min(building.values())
        result |= {name: level - ground for name, level in building.items()}
    return result


def _spread(building: dict[str, int], neighbors: Mapping[str, list[str]], stop: str, level: int) -> None:
    """Set the level of a stop and of the waypoints that lanes connect to it, unless they have one already."""
    reached = [stop]
    while reached:
        name = reached.pop()
        if name not in building:
            building[name] = level
            reached += neighbors[name]


def connected(joined: Iterable[tuple[str, str]]) -> dict[str, str]:
    """Return for each name the representative of those that pairs of names connect it with, in order of the pairs."""
    top: dict[str, str] = {}

    def find(name: str) -> str:
        while top.setdefault(name, name) != name:
            top[name] = top[top[name]]
            name = top[name]
        return name

    for start, end in joined:
        top[find(end)] = find(start)
    return {name: find(name) for name in top}


def nearest(waypoints: Mapping[str, Point], points: Mapping[str, Point]) -> dict[str, str]:
    """Return the waypoint nearest to each point, as the crow flies; of equally near ones the first by name.

    Raises:
        ValueError: There are points but no waypoints.
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
        candidate = distance(point, at), name
        best = candidate if best is None else min(best, candidate)
    if best is None:
        raise ValueError("there is no waypoint")
    return best[1]


@dataclass(frozen=True)
class Pairs:
    """Lanes in both directions without settings, as ``[from, to]`` in a world file.

    They are not validated one by one. Their reader ensures that each lane joins two different waypoints of the file,
    and that no two lanes are equal.

    Attributes:
        names: The names of waypoints.
        starts: By lane, the index in *names* of where it begins.
        ends: By lane, the index in *names* of where it ends.
        reach: Upper bound of the lanes' lengths.
        beside: Outlines of obstacles that no lane touches.
    """

    names: Sequence[str]
    starts: array[int]
    ends: array[int]
    reach: float
    beside: AbstractSet[tuple[Point, ...]] = frozenset()

    def __len__(self) -> int:
        """Return the number of lanes."""
        return len(self.starts)

    def __iter__(self) -> Iterator[tuple[str, str]]:
        """Yield the names of each lane's ends, in order."""
        name = self.names.__getitem__
        return zip(map(name, self.starts), map(name, self.ends), strict=True)

    def __getitem__(self, number: int) -> tuple[str, str]:
        """Return the names of a lane's ends."""
        return self.names[self.starts[number]], self.names[self.ends[number]]

    def touched(self) -> list[str]:
        """Return the names of the waypoints that the lanes join, in order."""
        joined = {*self.starts, *self.ends}
        return [name for number, name in enumerate(self.names) if number in joined]
