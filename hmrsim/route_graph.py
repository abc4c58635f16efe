"""The ways open to the robots, as the GeoJSON of Nav2's Route Server."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hmrsim.graph import WaypointGraph


def to_geojson(graph: WaypointGraph) -> dict[str, Any]:
    """Return a waypoint graph as a GeoJSON feature collection.

    Nodes are points and lanes are MultiLineStrings, one for each direction, with the properties ``id``,
    ``startid`` and ``endid`` of Nav2's graph files; names, lengths, limits and capacities are metadata.
    """
    ids = {name: number for number, name in enumerate(graph.waypoints)}
    features = [
        _feature("Point", [*graph.waypoints[name]], {"id": number, "frame": "map", "metadata": {"name": name}})
        for name, number in ids.items()
    ]
    for number, way in enumerate(graph.ways, start=len(ids)):
        metadata: dict[str, float] = {"length": way.length}
        if way.speed_limit < math.inf:
            metadata["abs_speed_limit"] = way.speed_limit
        if way.capacity is not None:
            metadata["capacity"] = way.capacity
        line = [[*graph.waypoints[way.start]], [*graph.waypoints[way.end]]]
        properties = {"id": number, "startid": ids[way.start], "endid": ids[way.end], "metadata": metadata}
        features.append(_feature("MultiLineString", [line], properties))
    return {"type": "FeatureCollection", "name": graph.name, "features": features}


def _feature(kind: str, coordinates: list[Any], properties: dict[str, Any]) -> dict[str, Any]:
    return {"type": "Feature", "properties": properties, "geometry": {"type": kind, "coordinates": coordinates}}
