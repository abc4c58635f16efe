"""A level of an Open-RMF building: its vertices with their parameters, and the edges between them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING

from hmrsim.world.formats._part import BadPart, Part

if TYPE_CHECKING:
    from hmrsim.world.formats._alignment import Alignment
    from hmrsim.world.formats._reading import Reading

_NAMED = 3
"""A vertex is [x, y, elevation, name, parameters]; an edge is [from, to, parameters]."""

_DIGITS = 9


@dataclass(frozen=True)
class _Described:
    """A part with parameters."""

    part: Part
    parameters: Mapping[str, Part]

    def text(self, key: str) -> str:
        """Return a parameter as text; empty if it isn't there."""
        return _text(self.parameters[key]) if key in self.parameters else ""

    def flag(self, key: str) -> bool:
        """Return whether a parameter is there and true."""
        return key in self.parameters and self.parameters[key].value is True


@dataclass(frozen=True)
class Vertex(_Described):
    """A vertex.

    Attributes:
        drawn: Where it is in the drawing, y up.
        name: Its name; empty for none.
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
    """A level.

    Attributes:
        elevation: Metres above the ground.
        vertices: Its vertices by their indices, without those that can't be read.
        fiducials: Named points that other levels have, too.
        lines: Its lines by kind.
        align: Tells where in metres a point of the drawing is, were this the only level.
        shift: How far it is moved along x, to be beside the others.
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
        """Return where a vertex is, in metres."""
        return self.align(self.vertices[index].drawn) + self.shift

    def point(self, index: int) -> list[float]:
        """Return the same as in a world file, without what turning and scaling leave in the last digits."""
        at = self.at(index)
        return [round(at.real, _DIGITS) + 0.0, round(at.imag, _DIGITS) + 0.0]

    def scale(self) -> float | None:
        """Return metres a unit of the drawing: the mean of what the measurements say; None if there are none."""
        scales = []
        for line in self.lines["measurements"]:
            a, b = (self.vertices[index].drawn for index in line.ends)
            if a != b and "distance" in line.parameters:
                scales.append(line.parameters["distance"].number() / abs(a - b))
        return math.fsum(scales) / len(scales) if scales else None


def read_level(reading: Reading, name: str, part: Part, *, down: bool) -> Level:
    """Return a level, without what can't be read.

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
    """Return what may be text; a name of digits is a number to YAML."""
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
    """Return a line; nothing if one of its vertices can't be read."""
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
