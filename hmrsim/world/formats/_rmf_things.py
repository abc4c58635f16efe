"""The vertices and lines of an Open-RMF building as waypoints, lanes, walls, doors, docks and robots."""

from __future__ import annotations

import cmath
import math
import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from hmrsim.world.formats._levels import Names
from hmrsim.world.formats._ways import Ways

if TYPE_CHECKING:
    from hmrsim.diagnostics import Path
    from hmrsim.world.formats._part import Part
    from hmrsim.world.formats._reading import Reading
    from hmrsim.world.formats._rmf_level import Level, Line, Vertex
    from hmrsim.world.options import ReadOptions

_OF_VERTICES = frozenset(("is_charger", "dock_name", "spawn_robot_name", "spawn_robot_type"))
_OF_LANES = frozenset(("bidirectional", "speed_limit", "graph_idx"))
"""Parameters that are read."""

_OF_LEVELS = ("models", "floors", "holes", "human_lanes")
"""Lists that are ignored."""

_NOT_IN_A_NAME = re.compile(r"[^A-Za-z0-9_]")

_BUILT_IN = ("carrier", "fetcher")


class Things:
    """Converts the levels.

    Attributes:
        data: The keys of a world.
        robots: What the robots are called there.
    """

    def __init__(self, reading: Reading, levels: Sequence[Level], options: ReadOptions) -> None:
        self.reading = reading
        self.options = options
        self.ways = Ways(reading)
        several = len(levels) > 1
        named = [[vertex.name for vertex in level.vertices.values() if vertex.name] for level in levels]
        doors = [[door.text("name") for door in level.lines["doors"] if door.text("name")] for level in levels]
        docks = [
            [vertex.text("dock_name") for vertex in level.vertices.values() if vertex.text("dock_name")]
            for level in levels
        ]
        self.names = Names(named, several=several)
        self.doors = Names(doors, several=several)
        self.docks = Names(docks, several=several)
        self.data: dict[str, Any] = {key: {} for key in ("waypoints", "places", "docks", "doors", "robots")}
        self.data["walls"] = []
        self.robots: list[str] = []

    def keep(self, key: str, name: str, value: object, part: Part) -> None:
        """Add something that has a name."""
        self.data[key][name] = value
        self.reading.origin((key, name), part)

    def leave_out(self, parameters: dict[str, Part], known: frozenset[str]) -> None:
        """Tell of parameters that mean nothing here, if they say anything."""
        for name, value in parameters.items():
            if name not in known and value.value not in (None, "", False, 0):
                self.reading.leave_out(name, value)


def things(reading: Reading, levels: Sequence[Level], options: ReadOptions) -> Things:
    """Return what the levels bring, as in a world file, and name their waypoints."""
    found = Things(reading, levels, options)
    for level in levels:
        _vertices(found, level)
        _lines(found, level)
        for kind in _OF_LEVELS:
            part = level.part.get(kind)
            if part is not None and part.value:
                reading.leave_out(kind, part, len(part.value) if isinstance(part.value, (list, dict)) else 1)
    _tell_of_graphs(reading, [lane for level in levels for lane in level.lines["lanes"]])
    found.data["lanes"] = found.ways.lanes()
    return found


def _tell_of_graphs(reading: Reading, lanes: Sequence[Line]) -> None:
    """Tell that each fleet has a graph of its own there, while here all robots drive on all lanes."""
    first: dict[str, Part] = {}
    for lane in lanes:
        first.setdefault(lane.text("graph_idx"), lane.part)
    if len(first) > 1:
        _, other, *_ = first.values()
        reading.leave_out("graphs of lanes", other, len(first), done="made one")


def _vertices(found: Things, level: Level) -> None:
    """Read the vertices: those that a lane touches are waypoints, others that have a name are places."""
    on_lanes = {end for lane in level.lines["lanes"] for end in lane.ends}
    for i, vertex in level.vertices.items():
        here = level.point(i)
        charger, dock = vertex.flag("is_charger"), vertex.text("dock_name")
        spawned = vertex.text("spawn_robot_name")
        name = ""
        if i in on_lanes or vertex.name or charger:
            name = found.names.give(level.name, vertex.name, f"v{i}")
        if i in on_lanes:
            level.names[i] = name
            found.keep("waypoints", name, here, vertex.part)
        elif vertex.name:
            found.keep("places", name, {"at": here}, vertex.part)
        if charger or dock:
            called = found.docks.give(level.name, dock or name, f"dock_{i}")
            found.keep("docks", called, {"at": here, **({"type": "charger"} if charger else {})}, vertex.part)
        if spawned:
            _robot(found, level, vertex, {"at": name if i in on_lanes else here, "yaw": _yaw(level, i)})
        found.leave_out(dict(vertex.parameters), _OF_VERTICES)


def _robot(found: Things, level: Level, vertex: Vertex, fields: dict[str, Any]) -> None:
    """Add a robot that starts at a vertex."""
    spawned, kind = vertex.text("spawn_robot_name"), vertex.text("spawn_robot_type")
    old = _NOT_IN_A_NAME.sub("_", spawned)
    old = old if old[:1].isalpha() else f"r{old}"
    if old != spawned:
        found.reading.warn(vertex.part, f"robot {spawned!r} is called {old!r}; names are of letters, digits and _")
    found.robots.append(old)
    name = found.options.rename.get(old, old)
    if name in found.data["robots"]:
        found.reading.complain(vertex.part, f"another robot on level {level.name!r} or before is called {name!r}, too")
        return
    if kind in _BUILT_IN:
        fields["type"] = kind
    elif kind:
        found.reading.leave_out("types of robots", vertex.parameters["spawn_robot_type"], done="made carriers")
    found.keep("robots", name, fields, vertex.part)


def _yaw(level: Level, index: int) -> float:
    """Return which way a robot faces: along the first lane that touches its vertex, as Open-RMF spawns it."""
    for lane in level.lines["lanes"]:
        if index in lane.ends:
            yaw = cmath.phase(level.at(lane.ends[1]) - level.at(lane.ends[0]))
            return math.remainder(yaw + math.pi, math.tau) if lane.text("orientation") == "backward" else yaw
    return 0.0


def _lines(found: Things, level: Level) -> None:
    for lane in level.lines["lanes"]:
        start, end = (level.names[end] for end in lane.ends)
        part = lane.parameters.get("speed_limit")
        limit = found.reading.attempt(part.number) if part else None
        for ends in ((start, end), (end, start)) if lane.flag("bidirectional") else ((start, end),):
            found.ways.add(ends, lane.part, limit=limit if limit and limit > 0.0 else None)
        found.leave_out(dict(lane.parameters), _OF_LANES)
    for wall in level.lines["walls"]:
        a, b = (level.point(end) for end in wall.ends)
        if a != b:
            path: Path = ("walls", len(found.data["walls"]))
            found.reading.origin(path, wall.part)
            found.data["walls"].append([a, b])
    for i, door in enumerate(level.lines["doors"]):
        name = found.doors.give(level.name, door.text("name"), f"door_{i}")
        fields: dict[str, Any] = {"at": [level.point(end) for end in door.ends]}
        if door.text("type"):
            fields["type"] = door.text("type")
        found.keep("doors", name, fields, door.part)
