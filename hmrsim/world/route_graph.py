"""The graph of a world's open lanes as GeoJSON, which Nav2's Route Server can read."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from itertools import count
from typing import TYPE_CHECKING, Any, NamedTuple

from hmrsim.geometry import distance
from hmrsim.world.model import Waypoint

if TYPE_CHECKING:
    from hmrsim.world.model import Lane, World


class RouteIds(NamedTuple):
    """The numbers of waypoints, and of lanes in each direction, which stay the same when lanes are closed.

    Attributes:
        nodes: The number of each waypoint, by its name.
        edges: The number of each lane and ride, by the names of its first and last waypoint; rides come last.
    """

    nodes: Mapping[str, int]
    edges: Mapping[tuple[str, str], int]


def route_ids(world: World) -> RouteIds:
    """Return the numbers of the nodes and edges of a world's route graph, as `to_geojson` writes them."""
    numbers = count()
    nodes = {name: next(numbers) for name in world.waypoints}
    lanes = {(start, end): next(numbers) for _, start, end in _ways(world)}
    return RouteIds(nodes, lanes | {(start, end): next(numbers) for start, end, *_ in world.rides})


def to_geojson(world: World, *, closed: Collection[tuple[str, str]] = (), lifts: bool = False) -> dict[str, Any]:
    """Return the waypoints and lanes of a world as a GeoJSON feature collection, which `hmrsim.world` reads again.

    Waypoints are points, and lanes are MultiLineStrings, one for each direction, with the properties ``id``,
    ``startid``, ``endid`` and ``cost`` of Nav2's graph files. Their metadata are names, lengths, speed limits and
    capacities, and ``one_way`` for lanes with a single direction.

    Args:
        world: The world.
        closed: The first and last waypoints of closed lanes, which are left out.
        lifts: Whether to include rides in lifts, as edges whose cost is their duration in seconds.
    """
    ids, numbers = route_ids(world)
    features = [_node(world, name, number) for name, number in ids.items()]
    for lane, start, end in _ways(world):
        if (start, end) in closed:
            continue
        a, b = world.points[start], world.points[end]
        length = distance(a, b)
        # Nav2 accepts a speed limit only if it is written as a float.
        metadata: dict[str, Any] = {"length": length}
        if lane.speed_limit is not None:
            metadata["abs_speed_limit"] = float(lane.speed_limit)
        if lane.capacity is not None:
            metadata["capacity"] = lane.capacity
        if lane.one_way:
            metadata["one_way"] = True
        ends = {"startid": ids[start], "endid": ids[end]}
        properties = {"id": numbers[start, end], **ends, "cost": length, "metadata": metadata}
        features.append(_feature("MultiLineString", [[[*a], [*b]]], properties))
    rides = [ride for ride in world.rides if ride[:2] not in closed] if lifts else []
    for start, end, lift, seconds in rides:
        line = [[[*world.points[start]], [*world.points[end]]]]
        ends = {"startid": ids[start], "endid": ids[end]}
        metadata = {"length": 0.0, "lift": lift, "ride": seconds}
        properties = {"id": numbers[start, end], **ends, "cost": seconds, "metadata": metadata}
        features.append(_feature("MultiLineString", line, properties))
    return {"type": "FeatureCollection", "name": world.name, "features": features}


def _node(world: World, name: str, number: int) -> dict[str, Any]:
    at = world.waypoints[name]
    metadata: dict[str, Any] = {"name": name}
    if isinstance(at, Waypoint) and at.capacity is not None:
        metadata["capacity"] = at.capacity
    return _feature("Point", [*world.points[name]], {"id": number, "frame": "map", "metadata": metadata})


def _ways(world: World) -> Iterator[tuple[Lane, str, str]]:
    """Yield the lanes in each direction in which they can be driven."""
    for lane in world.lanes:
        yield lane, lane.from_, lane.to
        if not lane.one_way:
            yield lane, lane.to, lane.from_


def _feature(kind: str, coordinates: list[Any], properties: dict[str, Any]) -> dict[str, Any]:
    return {"type": "Feature", "properties": properties, "geometry": {"type": kind, "coordinates": coordinates}}
