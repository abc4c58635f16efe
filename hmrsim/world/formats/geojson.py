"""The GeoJSON of Nav2's Route Server: nodes are points, edges are lines from one node's id to another's.

Members that Nav2 does not need are optional; edges are straight, whatever their line is.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any

from hmrsim.world.files import AS_IT_IS, ReadOptions
from hmrsim.world.formats import Format
from hmrsim.world.formats._layouts import Edges
from hmrsim.world.formats._reading import BadPart, Part, Reading, of_json

if TYPE_CHECKING:
    from hmrsim.world.formats import Document

_LOOKS = re.compile(r'\A\s*\{.*"type"\s*:\s*"FeatureCollection"', re.DOTALL)

_EDGES = ("LineString", "MultiLineString")

_WHOLE_SPEED = 1.0
"""The default maximum speed of robots in m/s, to which Nav2's percentages refer."""

_PERCENT = 100.0

_NODE_METADATA = frozenset(("name", "capacity"))
_EDGE_METADATA = frozenset(("length", "abs_speed_limit", "speed_limit", "capacity", "one_way"))
_MAPS = ("", "map")


@dataclass
class _Graph:
    """A route graph that is being read.

    Attributes:
        points: The positions of the waypoints.
        names: The names of the waypoints, by the ids of their nodes.
        taken: The names in use.
        data: The waypoints, as in a world file.
    """

    reading: Reading
    edges: Edges
    points: dict[str, complex] = field(default_factory=dict)
    names: dict[int, str] = field(default_factory=dict)
    taken: set[str] = field(default_factory=set)
    data: dict[str, Any] = field(default_factory=dict)


def _read(text: str, file: str, _options: ReadOptions = AS_IT_IS) -> Document:
    reading = of_json(text, file)
    graph = _Graph(reading, Edges(reading))
    nodes, edges = [], []
    for feature in reading.attempt(partial(reading.root.parts, "features")) or []:
        kind = reading.attempt(partial(_kind, feature))
        if kind == "Point":
            nodes.append(feature)
        elif kind in _EDGES:
            edges.append(feature)
        elif kind is not None:
            reading.leave_out("features that are neither nodes nor edges", feature)
    graph.taken = {name for node in nodes if (name := _own_name(node))}
    for node in nodes:
        reading.attempt(partial(_node, graph, node))
    for edge in edges:
        reading.attempt(partial(_edge, graph, edge))
    name = reading.root.value.get("name")
    data = {"waypoints": graph.data, "lanes": graph.edges.lanes()}
    return reading.document({"name": name[:100], **data} if isinstance(name, str) and name else data)


def _kind(feature: Part) -> str:
    """Return the type of a feature's geometry, or an empty text."""
    geometry = feature.get("geometry")
    kind = geometry.get("type") if geometry else None
    return kind.text() if kind else ""


def _own_name(node: Part) -> str | None:
    """Return the name of a node if it is valid; errors are reported later."""
    try:
        metadata = node.want("properties").get("metadata")
        name = metadata.get("name") if metadata else None
        return name.name() if name else None
    except BadPart:
        return None


def _node(graph: _Graph, node: Part) -> None:
    """Read a node.

    Raises:
        BadPart: It has no id, or that of another, or is nowhere.
    """
    properties = node.want("properties")
    identifier = properties.want("id")
    number = identifier.whole()
    if number in graph.names:
        raise BadPart(identifier, f"{number} is the id of another node, too; ids are unique")
    if number != len(graph.names):
        graph.reading.leave_out("ids of nodes that do not count from 0", identifier, done="given anew")
    point = node.want("geometry").want("coordinates").point()
    name = _name(graph, node, number)
    graph.names[number] = name
    graph.points[name] = point
    metadata = properties.get("metadata")
    capacity = metadata.get("capacity") if metadata else None
    at = [point.real, point.imag]
    graph.data[name] = {"at": at, "capacity": capacity.whole()} if capacity else at
    graph.reading.origin(("waypoints", name), node)
    frame = properties.get("frame")
    if frame and frame.value not in _MAPS:
        graph.reading.leave_out("frames other than map", frame)
    _leave_out(graph, properties, _NODE_METADATA)


def _name(graph: _Graph, node: Part, number: int) -> str:
    """Return the name of a node: the one in its metadata if it is unique, else one from its number."""
    own = _own_name(node)
    if own and own not in graph.data:
        return own
    name = f"node_{number}"
    while name in graph.taken or name in graph.data:
        name += "_"
    if own:
        graph.reading.warn(node, f"another node is called {own!r}, too; this one is called {name!r}")
    return name


def _edge(graph: _Graph, edge: Part) -> None:
    """Read an edge.

    Raises:
        BadPart: The edge does not name the nodes that it connects.
    """
    properties = edge.want("properties")
    start, end = (_end(graph, properties.want(key)) for key in ("startid", "endid"))
    metadata = properties.get("metadata") or Part({})
    if start == end:
        graph.reading.warn(edge, f"leads from {start!r} to itself; left out, as no robot could drive it")
        return
    capacity, alone, cost = metadata.get("capacity"), metadata.get("one_way"), properties.get("cost")
    graph.edges.add(
        (start, end),
        edge,
        limit=_limit(graph, metadata),
        capacity=capacity.whole() if capacity else None,
        alone=alone is not None and alone.value is True,
    )
    if cost and cost.number() and not math.isclose(cost.number(), abs(graph.points[end] - graph.points[start])):
        graph.reading.leave_out("costs other than the length", cost)
    _leave_out(graph, properties, _EDGE_METADATA)


def _end(graph: _Graph, part: Part) -> str:
    number = part.whole()
    if number not in graph.names:
        raise BadPart(part, f"no node has the id {number}")
    return graph.names[number]


def _limit(graph: _Graph, metadata: Part) -> float | None:
    """Return the speed limit of an edge in m/s, from Nav2's absolute limit or its percentage of the robot's speed."""
    absolute, relative = metadata.get("abs_speed_limit"), metadata.get("speed_limit")
    if absolute is not None and absolute.number() > 0.0:
        return absolute.number()
    if relative is None or not 0.0 < relative.number() < _PERCENT:
        return None
    # Nav2's documentation says percent, its own sample graph has 0.85.
    share = relative.number() if relative.number() <= 1.0 else relative.number() / _PERCENT
    if share == 1.0:
        return None
    graph.reading.leave_out("speed limits in percent", relative, done=f"taken of {_WHOLE_SPEED:g} m/s")
    return share * _WHOLE_SPEED


def _leave_out(graph: _Graph, properties: Part, known: frozenset[str]) -> None:
    """Report ignored data of a node or edge."""
    metadata, operations = properties.get("metadata"), properties.get("operations")
    if metadata and (more := metadata.value.keys() - known):
        graph.reading.leave_out("further metadata", metadata, len(more))
    if operations and operations.value:
        count = len(operations.value) if isinstance(operations.value, (dict, list)) else 1
        graph.reading.leave_out("operations", operations, count)


FORMAT = Format(name="geojson", suffixes=(".geojson",), matches=lambda text: bool(_LOOKS.match(text)), read=_read)
