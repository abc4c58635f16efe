"""The ways open to the robots, as the GeoJSON of Nav2's Route Server."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import networkx as nx


def to_geojson(graph: nx.DiGraph[str]) -> dict[str, Any]:
    """Return a waypoint graph as a GeoJSON feature collection.

    Nodes are points and lanes are MultiLineStrings, one for each direction, with the properties ``id``,
    ``startid`` and ``endid`` of Nav2's graph files; names, lengths, limits and capacities are metadata.
    """
    ids = {name: number for number, name in enumerate(graph.nodes)}
    features = [
        _feature("Point", [*graph.nodes[name]["point"]], {"id": number, "frame": "map", "metadata": {"name": name}})
        for name, number in ids.items()
    ]
    for number, (start, end, lane) in enumerate(graph.edges(data=True), start=len(ids)):
        metadata = {"length": lane["length"]}
        if lane["speed_limit"] < math.inf:
            metadata["abs_speed_limit"] = lane["speed_limit"]
        if lane["capacity"] is not None:
            metadata["capacity"] = lane["capacity"]
        line = [[*graph.nodes[start]["point"]], [*graph.nodes[end]["point"]]]
        properties = {"id": number, "startid": ids[start], "endid": ids[end], "metadata": metadata}
        features.append(_feature("MultiLineString", [line], properties))
    return {"type": "FeatureCollection", "name": graph.graph["name"], "features": features}


def _feature(kind: str, coordinates: list[Any], properties: dict[str, Any]) -> dict[str, Any]:
    return {"type": "Feature", "properties": properties, "geometry": {"type": kind, "coordinates": coordinates}}
