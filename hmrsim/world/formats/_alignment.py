"""From the coordinates of a level's drawing to metres, as Open-RMF's building_map_tools do it; points are complex."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Mapping, Sequence
from itertools import combinations
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    Alignment: TypeAlias = Callable[[complex], complex]
    """Tells where in metres a point of a drawing is."""

_EQUATOR = 6_378_137.0
_FLATTENING = 1 / 298.257223563
"""Of the ellipsoid WGS 84, in metres."""

_MAX_SPREAD = 1.0
"""Degrees around the middle that count as flat."""


def by_scale(scale: float, shift: complex = 0.0) -> Alignment:
    """Return what scales and then shifts; *scale* is metres a unit of the drawing, a complex one turns, too."""
    return lambda point: point * scale + shift


def by_fiducials(own: Mapping[str, complex], reference: Mapping[str, complex], scale: float) -> Alignment | None:
    """Return what lays a level onto the reference level; None if they have no two different points in common.

    Each pair of fiducials that both levels have tells a turn and a scale, each fiducial then a shift; all count alike.

    The points of both levels are named; *scale* is metres a unit of the reference level's drawing.
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
    """Return what lays longitudes and latitudes onto the plane that touches the Earth in the middle of *points*.

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
