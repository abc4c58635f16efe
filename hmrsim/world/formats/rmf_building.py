"""The buildings of Open-RMF's traffic editor: levels of vertices, and the lanes, walls and doors between them.

A lift stops at the waypoint in its cabin on each level that has a door to it.

Coordinates become meters, y up, as Open-RMF's building_map_tools make them; levels are put side by side.
"""

from __future__ import annotations

import cmath
import math
import re
from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from hmrsim.world.files import AS_IT_IS, ReadOptions
from hmrsim.world.formats import Format
from hmrsim.world.formats._layouts import Edges, Names, choose_page, side_by_side
from hmrsim.world.formats._reading import BadPart, Part, Reading, of_yaml
from hmrsim.world.formats._rmf_level import Level, by_degrees, by_fiducials, by_scale, read_level

if TYPE_CHECKING:
    from hmrsim.diagnostics import Path
    from hmrsim.world.formats import Document
    from hmrsim.world.formats._rmf_level import Line, Vertex


_GAP = 0.05
"""Meters between cabin and shaft; a vertex in the shaft is in the lift."""

_MIN_STOPS = 2
"""The minimum number of stops of a lift."""


def _lifts(reading: Reading, levels: Mapping[str, Level], reference: Level, *, down: bool) -> dict[str, Any]:
    """Return the lifts, as in a world file.

    Args:
        reading: The file.
        levels: All levels by name; the waypoints of those that are read have names.
        reference: The level for the drawing of lifts that name no level.
        down: Whether y points down in drawings.
    """
    found: dict[str, Any] = {}
    part = reading.root.get("lifts") or Part({})
    for name, lift in reading.attempt(lambda: list(part.entries())) or ():
        stops = reading.attempt(partial(_stops, levels, reference, lift, down=down))
        if stops is not None and len(stops) < _MIN_STOPS:
            reading.leave_out("lifts with no waypoints on two levels in their cabins", lift)
        elif stops is not None:
            found[name] = {"stops": stops}
            reading.origin(("lifts", name), lift)
    return found


def _stops(levels: Mapping[str, Level], reference: Level, lift: Part, *, down: bool) -> list[str]:
    """Return the names of the waypoints where a lift stops, from the lowest level up.

    Raises:
        BadPart: Its position is missing, or a level is unknown.
    """
    drawn = complex(lift.want("x").number(), lift.want("y").number())
    own = lift.get("reference_floor_name")
    reference = _level(levels, own, str(own.value)) if own and own.value else reference
    center = reference.align(drawn.conjugate() if down else drawn)
    doors = lift.get("level_doors") or Part({})
    served = [_level(levels, part, name) for name, part in doors.entries() if part.value]
    inside = (_in_cabin(lift, center, level) for level in sorted(served, key=lambda level: level.elevation))
    return [name for name in inside if name]


def _level(levels: Mapping[str, Level], part: Part, name: str) -> Level:
    if name not in levels:
        raise BadPart(part, f"no level {name!r}; there are {', '.join(levels)}")
    return levels[name]


def _in_cabin(lift: Part, center: complex, level: Level) -> str:
    """Return the waypoint of a level nearest to the center of a lift's cabin; empty if none is in it."""
    width, depth, yaw = (lift.want(key).number() for key in ("width", "depth", "yaw"))
    inside = []
    for index, name in level.names.items():
        away = (level.at(index) - level.shift - center) * cmath.rect(1.0, -yaw)
        if abs(away.real) <= width / 2.0 + _GAP and abs(away.imag) <= depth / 2.0 + _GAP:
            inside.append((abs(away), name))
    return min(inside)[1] if inside else ""


_OF_VERTICES = frozenset(("is_charger", "dock_name", "spawn_robot_name", "spawn_robot_type"))
_OF_LANES = frozenset(("bidirectional", "speed_limit", "graph_idx"))
"""Parameters that are read."""

_OF_LEVELS = ("models", "floors", "holes", "human_lanes")
"""Lists that are ignored."""

_NOT_IN_A_NAME = re.compile(r"[^A-Za-z0-9_]")

_BUILT_IN = ("carrier", "fetcher")


class Conversion:
    """The conversion of levels into the keys of a world.

    Attributes:
        data: The keys of a world.
        robots: The names of the robots in the building.
    """

    def __init__(self, reading: Reading, levels: Sequence[Level], options: ReadOptions) -> None:
        self.reading = reading
        self.options = options
        self.edges = Edges(reading)
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
        """Add a named entity."""
        self.data[key][name] = value
        self.reading.origin((key, name), part)

    def leave_out(self, parameters: dict[str, Part], known: frozenset[str]) -> None:
        """Report parameters that have no meaning here, unless they are empty."""
        for name, value in parameters.items():
            if name not in known and value.value not in (None, "", False, 0):
                self.reading.leave_out(name, value)


def convert(reading: Reading, levels: Sequence[Level], options: ReadOptions) -> Conversion:
    """Convert the levels to the keys of a world, and name their waypoints."""
    conversion = Conversion(reading, levels, options)
    for level in levels:
        _vertices(conversion, level)
        _lines(conversion, level)
        for kind in _OF_LEVELS:
            part = level.part.get(kind)
            if part is not None and part.value:
                reading.leave_out(kind, part, len(part.value) if isinstance(part.value, (list, dict)) else 1)
    _report_graphs(reading, [lane for level in levels for lane in level.lines["lanes"]])
    conversion.data["lanes"] = conversion.edges.lanes()
    return conversion


def _report_graphs(reading: Reading, lanes: Sequence[Line]) -> None:
    """Report that fleets have their own graphs there, while all robots use all lanes here."""
    first: dict[str, Part] = {}
    for lane in lanes:
        first.setdefault(lane.text("graph_idx"), lane.part)
    if len(first) > 1:
        _, other, *_ = first.values()
        reading.leave_out("graphs of lanes", other, len(first), done="made one")


def _vertices(conversion: Conversion, level: Level) -> None:
    """Read the vertices: as waypoints if a lane touches them, else as places if they have a name."""
    on_lanes = {end for lane in level.lines["lanes"] for end in lane.ends}
    for i, vertex in level.vertices.items():
        here = level.point(i)
        charger, dock = vertex.flag("is_charger"), vertex.text("dock_name")
        spawned = vertex.text("spawn_robot_name")
        name = ""
        if i in on_lanes or vertex.name or charger:
            name = conversion.names.give(level.name, vertex.name, f"v{i}")
        if i in on_lanes:
            level.names[i] = name
            conversion.keep("waypoints", name, here, vertex.part)
        elif vertex.name:
            conversion.keep("places", name, {"at": here}, vertex.part)
        if charger or dock:
            called = conversion.docks.give(level.name, dock or name, f"dock_{i}")
            conversion.keep("docks", called, {"at": here, **({"type": "charger"} if charger else {})}, vertex.part)
        if spawned:
            _robot(conversion, level, vertex, {"at": name if i in on_lanes else here, "yaw": _yaw(level, i)})
        conversion.leave_out(dict(vertex.parameters), _OF_VERTICES)


def _robot(conversion: Conversion, level: Level, vertex: Vertex, fields: dict[str, Any]) -> None:
    """Add a robot that starts at a vertex."""
    spawned, kind = vertex.text("spawn_robot_name"), vertex.text("spawn_robot_type")
    old = _NOT_IN_A_NAME.sub("_", spawned)
    old = old if old[:1].isalpha() else f"r{old}"
    if old != spawned:
        conversion.reading.warn(vertex.part, f"robot {spawned!r} is called {old!r}; names are of letters, digits and _")
    conversion.robots.append(old)
    name = conversion.options.rename.get(old, old)
    if name in conversion.data["robots"]:
        conversion.reading.complain(
            vertex.part, f"another robot on level {level.name!r} or before is called {name!r}, too"
        )
        return
    if kind in _BUILT_IN:
        fields["type"] = kind
    elif kind:
        conversion.reading.leave_out("types of robots", vertex.parameters["spawn_robot_type"], done="made carriers")
    conversion.keep("robots", name, fields, vertex.part)


def _yaw(level: Level, index: int) -> float:
    """Return the yaw of a robot: along the first lane that touches its vertex, as Open-RMF spawns it."""
    for lane in level.lines["lanes"]:
        if index in lane.ends:
            yaw = cmath.phase(level.at(lane.ends[1]) - level.at(lane.ends[0]))
            return math.remainder(yaw + math.pi, math.tau) if lane.text("orientation") == "backward" else yaw
    return 0.0


def _lines(conversion: Conversion, level: Level) -> None:
    for lane in level.lines["lanes"]:
        start, end = (level.names[end] for end in lane.ends)
        part = lane.parameters.get("speed_limit")
        limit = conversion.reading.attempt(part.number) if part else None
        for ends in ((start, end), (end, start)) if lane.flag("bidirectional") else ((start, end),):
            conversion.edges.add(ends, lane.part, limit=limit if limit and limit > 0.0 else None)
        conversion.leave_out(dict(lane.parameters), _OF_LANES)
    for wall in level.lines["walls"]:
        a, b = (level.point(end) for end in wall.ends)
        if a != b:
            path: Path = ("walls", len(conversion.data["walls"]))
            conversion.reading.origin(path, wall.part)
            conversion.data["walls"].append([a, b])
    for i, door in enumerate(level.lines["doors"]):
        name = conversion.doors.give(level.name, door.text("name"), f"door_{i}")
        fields: dict[str, Any] = {"at": [level.point(end) for end in door.ends]}
        if door.text("type"):
            fields["type"] = door.text("type")
        conversion.keep("doors", name, fields, door.part)


_LOOKS = re.compile(r"""^["']?levels["']?[ ]*:""", re.MULTILINE)

_IMAGE, _METRES, _DEGREES = "reference_image", "cartesian_meters", "wgs84"


def _read(text: str, file: str, options: ReadOptions = AS_IT_IS) -> Document:
    reading = of_yaml(text, file)
    root = reading.root
    system = reading.attempt(partial(_system, root)) or _IMAGE
    levels = [
        read_level(reading, name, part, down=system == _IMAGE)
        for name, part in reading.attempt(lambda: list(root.want("levels").entries())) or ()
    ]
    if not levels:
        reading.complain(reading.root, "has no levels")
        return reading.document({})
    named = {level.name: level for level in levels}
    reference = reading.attempt(partial(_reference, root, named)) or levels[0]
    _align(reading, levels, reference, system)
    pages = tuple(level.name for level in levels)
    chosen = levels if options.page is None else [levels[choose_page(pages, options.page, file, noun="level")]]
    for level, shift in zip(chosen, side_by_side([map(level.at, level.vertices) for level in chosen]), strict=True):
        level.shift = shift
    conversion = convert(reading, chosen, options)
    lifts = _lifts(reading, named, reference, down=system == _IMAGE)
    data = {"name": _name(root), **conversion.data, "lifts": lifts}
    return reading.document(data, pages=pages, robots=tuple(conversion.robots))


def _name(root: Part) -> str:
    name = root.value.get("building_name") or root.value.get("name")
    return str(name)[:100] if name else "building"


def _system(root: Part) -> str:
    """Return the coordinate system.

    Raises:
        BadPart: It is not supported.
    """
    part = root.get("coordinate_system") or Part(_IMAGE)
    if part.value not in (_IMAGE, _METRES, _DEGREES):
        raise part.expected(f"{_IMAGE}, {_METRES} or {_DEGREES}")
    return part.text()


def _align(reading: Reading, levels: list[Level], reference: Level, system: str) -> None:
    """Set the alignment of each level."""
    if system == _IMAGE:
        _align_images(reading, levels, reference)
    elif system == _DEGREES:
        align = by_degrees([vertex.drawn for level in levels for vertex in level.vertices.values()])
        if align is None:
            reading.complain(reading.root.want("levels"), "is not around one place; expected longitudes and latitudes")
        for level in levels:
            level.align = align or level.align


def _align_images(reading: Reading, levels: list[Level], reference: Level) -> None:
    """Scale the reference level by its measurements, and align the others with it by common fiducials."""
    scale = reading.attempt(reference.scale)
    if scale is None:
        reading.warn(reference.part, "has no measurements, so that a pixel of its drawing counts as a meter")
        scale = 1.0
    reference.align = by_scale(scale)
    for level in levels:
        if level is not reference:
            onto = by_fiducials(level.fiducials, reference.fiducials, scale)
            level.align = onto or by_scale(reading.attempt(level.scale) or scale)


def _reference(root: Part, levels: Mapping[str, Level]) -> Level | None:
    name = root.get("reference_level_name")
    return None if name is None or name.value == "" else _level(levels, name, str(name.value))


FORMAT = Format(
    name="rmf_building", suffixes=(".building.yaml",), matches=lambda text: bool(_LOOKS.search(text)), read=_read
)
