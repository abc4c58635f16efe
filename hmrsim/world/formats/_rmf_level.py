"""Levels of Open-RMF buildings: vertices, the edges between them, and their alignment in meters.

Points are complex numbers. The alignment is that of Open-RMF's building_map_tools.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import combinations
from typing import TYPE_CHECKING, TypeAlias

from hmrsim.world.formats._reading import BadPart, Part

if TYPE_CHECKING:
    from hmrsim.world.formats._reading import Reading

if TYPE_CHECKING:
    Alignment: TypeAlias = Callable[[complex], complex]
    """Returns the position in meters of a point of a drawing."""

_EQUATOR = 6_378_137.0
_FLATTENING = 1 / 298.257223563
"""The ellipsoid WGS 84: equatorial radius in meters, and flattening."""

_MAX_SPREAD = 1.0
"""Degrees around the middle that count as flat."""


def by_scale(scale: float) -> Alignment:
    """Return an alignment that scales; *scale* is meters per unit."""
    return lambda point: point * scale


def by_fiducials(own: Mapping[str, complex], reference: Mapping[str, complex], scale: float) -> Alignment | None:
    """Return the alignment of a level with the reference level, or None without two different common points.

    Each pair of common fiducials gives a rotation and a scale, and each fiducial then a shift; they are averaged.

    *own* and *reference* are the named points of both levels, and *scale* is meters per unit of the reference level.
    """
    common = [(own[name], point) for name, point in reference.items() if name in own]
    sides = [(b - a, to - at) for (a, at), (b, to) in combinations(common, 2) if a != b and at != to]
    if not sides:
        return None
    turn = -cmath.phase(sum(side / abs(side) / (other / abs(other)) for side, other in sides))
    relative = math.fsum(abs(side) / abs(other) for side, other in sides) / len(sides)
    factor = cmath.rect(scale / relative, turn)
    shift = sum(other * scale - point * factor for point, other in common) / len(common)
    return lambda point: point * factor + shift


def by_degrees(points: Sequence[complex]) -> Alignment | None:
    """Return the projection of longitudes and latitudes onto the plane tangent to the Earth in the middle of *points*.

    That is the plane's origin. None if they are not around one place of the Earth.
    """
    middle = sum(points) / max(len(points), 1)
    if abs(middle.imag) > 90.0 - _MAX_SPREAD or any(abs(point - middle) > _MAX_SPREAD for point in points):
        return None
    latitude = math.radians(middle.imag)
    eccentricity = _FLATTENING * (2.0 - _FLATTENING)
    bend = 1.0 - eccentricity * math.sin(latitude) ** 2
    east = math.radians(_EQUATOR / math.sqrt(bend) * math.cos(latitude))
    north = math.radians(_EQUATOR * (1.0 - eccentricity) / bend**1.5)

    def align(point: complex) -> complex:
        away = point - middle
        return complex(away.real * east, away.imag * north)

    return align


_NAMED = 3
"""A vertex is [x, y, elevation, name, parameters]; an edge is [from, to, parameters]."""

_DIGITS = 9


@dataclass(frozen=True)
class _Described:
    """A vertex or edge with parameters."""

    part: Part
    parameters: Mapping[str, Part]

    def text(self, key: str) -> str:
        """Return a parameter as text, or an empty text if it is missing."""
        return _text(self.parameters[key]) if key in self.parameters else ""

    def flag(self, key: str) -> bool:
        """Return whether a parameter exists and is true."""
        return key in self.parameters and self.parameters[key].value is True


@dataclass(frozen=True)
class Vertex(_Described):
    """A vertex of a level's graph.

    Attributes:
        drawn: Its position in the drawing, y up.
        name: Its name, or an empty text.
    """

    drawn: complex
    name: str


@dataclass(frozen=True)
class Line(_Described):
    """An edge between two vertices: a lane, a wall, a door or a measurement.

    Attributes:
        ends: The indices of the vertices.
    """

    ends: tuple[int, int]


@dataclass
class Level:
    """A level of a building.

    Attributes:
        elevation: Meters above the ground.
        vertices: Its valid vertices by their indices.
        fiducials: Named points that other levels also have.
        lines: Its lines by kind.
        align: Returns the position in meters of a point of the drawing, before the shift.
        shift: The shift along x that places it beside the others.
        names: The names of its waypoints, by the indices of their vertices.
    """

    name: str
    part: Part
    elevation: float = 0.0
    vertices: dict[int, Vertex] = field(default_factory=dict)
    fiducials: dict[str, complex] = field(default_factory=dict)
    lines: dict[str, list[Line]] = field(default_factory=dict)
    align: Alignment = field(default=lambda point: point)
    shift: float = 0.0
    names: dict[int, str] = field(default_factory=dict)

    def at(self, index: int) -> complex:
        """Return the position of a vertex in meters."""
        return self.align(self.vertices[index].drawn) + self.shift

    def point(self, index: int) -> list[float]:
        """Return the position of a vertex as in a world file, without rounding errors."""
        at = self.at(index)
        return [round(at.real, _DIGITS) + 0.0, round(at.imag, _DIGITS) + 0.0]

    def scale(self) -> float | None:
        """Return the mean scale of the measurements in meters per unit of the drawing, or None without measurements."""
        scales = []
        for line in self.lines["measurements"]:
            a, b = (self.vertices[index].drawn for index in line.ends)
            if a != b and "distance" in line.parameters:
                scales.append(line.parameters["distance"].number() / abs(a - b))
        return math.fsum(scales) / len(scales) if scales else None


def read_level(reading: Reading, name: str, part: Part, *, down: bool) -> Level:
    """Return a level without its invalid parts.

    *down* says whether y points down.
    """
    if not isinstance(part.value, dict):
        reading.complain(part, str(part.expected("a mapping")))
        part = Part({}, part.path)
    level = Level(name, part)
    for i, vertex in enumerate(reading.attempt(partial(part.parts, "vertices")) or []):
        read = reading.attempt(partial(_vertex, vertex, down=down))
        if read is not None:
            level.vertices[i] = read
    for fiducial in reading.attempt(partial(part.parts, "fiducials")) or []:
        reading.attempt(partial(_fiducial, level, fiducial, down=down))
    for kind in ("measurements", "lanes", "walls", "doors"):
        lines = (
            reading.attempt(partial(_line, level, line)) for line in reading.attempt(partial(part.parts, kind)) or []
        )
        level.lines[kind] = [line for line in lines if line is not None]
    level.elevation = reading.attempt((part.get("elevation") or Part(0.0)).number) or 0.0
    return level


def _vertex(part: Part, *, down: bool) -> Vertex:
    values = part.all()
    name = _text(values[_NAMED]) if len(values) > _NAMED else ""
    return Vertex(part, _parameters(values[_NAMED + 1 :]), _point(part, down=down), name)


def _text(part: Part) -> str:
    """Return a value as text; YAML reads a name of digits as a number."""
    return "" if part.value is None else str(part.value)


def _point(part: Part, *, down: bool) -> complex:
    point = part.point()
    return point.conjugate() if down else point


def _fiducial(level: Level, part: Part, *, down: bool) -> None:
    values = part.all()
    if len(values) < _NAMED:
        raise part.expected("[x, y, name]")
    level.fiducials[str(values[2].value)] = _point(part, down=down)


def _line(level: Level, part: Part) -> Line | None:
    """Return a line, or None if one of its vertices is invalid."""
    values = part.all()
    if len(values) < 2:  # noqa: PLR2004
        raise part.expected("[from, to, parameters]")
    ends = values[0].whole(), values[1].whole()
    count = len(level.part.parts("vertices"))
    for value, end in zip(values, ends, strict=False):
        if not 0 <= end < count:
            raise BadPart(value, f"no vertex {end}; there are {count}, from 0 on")
    if any(end not in level.vertices for end in ends):
        return None
    return Line(part, _parameters(values[2:]), ends)


def _parameters(values: list[Part]) -> dict[str, Part]:
    """Return the values of parameters, each of which is [type, value].

    Raises:
        BadPart: They are no such mapping.
    """
    found: dict[str, Part] = {}
    for name, pair in values[0].entries() if values and values[0].value is not None else ():
        if not isinstance(pair.value, list) or len(pair.value) != 2:  # noqa: PLR2004
            raise pair.expected("[type, value]")
        found[name] = pair.all()[1]
    return found
