"""Construction of markers as plain values, which is much faster than messages."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from importlib.resources import files
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final

from hmrsim.interfaces.builtin_interfaces import values_of
from hmrsim.interfaces.visualization_msgs import Marker

if TYPE_CHECKING:
    Point = Sequence[float]

MAP: Final = "map"
"""The frame of static objects."""

_FLAT: Final = {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}
_HALF_ROUND: Final = {"x": 1.0, "y": 0.0, "z": 0.0, "w": 0.0}
"""Half a turn about the x axis."""

_TEXT_HEIGHT: Final = 0.3
_THIN: Final = 0.15
"""An arrow's width relative to its length."""


class Marking:
    """Collects markers that replace all earlier ones.

    Args:
        time: The stamp in nanoseconds.
        unit: About a metre in the world's unit; all sizes and heights are in metres.
        up: 1, or -1 in a frame that is upside down.
    """

    def __init__(self, time: int, *, unit: float = 1.0, up: float = 1.0) -> None:
        self._stamp = values_of(time)
        self._up = up
        self.unit = unit
        self._markers: list[dict[str, Any]] = [self._marker(MAP, "", action=Marker.DELETEALL)]

    def array(self) -> dict[str, Any]:
        """Return all markers as a MarkerArray."""
        return {"markers": self._markers}

    def upside_down(self, outer: str, inner: str) -> dict[str, Any]:
        """Return a TFMessage in which the inner frame is upside down in the outer one."""
        transform = {"translation": _xyz(), "rotation": _HALF_ROUND}
        header = {"stamp": self._stamp, "frame_id": outer}
        return {"transforms": [{"header": header, "child_frame_id": inner, "transform": transform}]}

    def at(
        self,
        ns: str,
        kind: int,
        at: Point,
        across: float,
        paint: str | Mapping[str, float],
        *,
        z: float = 0.0,
        high: float = 0.0,
        frame: str = MAP,
    ) -> None:
        """Add a marker at a point; by default it is as high as it is wide."""
        size, tall = across * self.unit, (high or across) * self.unit
        width = size * _THIN if kind == Marker.ARROW else size
        self._add(
            frame,
            ns,
            type=kind,
            pose=self._pose(at, z),
            scale=_xyz(size, width, tall),
            color=colour(paint) if isinstance(paint, str) else paint,
            frame_locked=frame != MAP,
        )

    def text(self, ns: str, text: str, at: Point, *, z: float = 0.4, frame: str = MAP) -> None:
        """Add a label above a point."""
        scale = _xyz(z=_TEXT_HEIGHT * self.unit)
        looks = {"scale": scale, "color": colour("muted"), "text": text, "frame_locked": frame != MAP}
        self._add(frame, ns, type=Marker.TEXT_VIEW_FACING, pose=self._pose(at, z), **looks)

    def lines(
        self, ns: str, ways: Iterable[Sequence[Point]], width: float, paint: str, *, z: float = 0.0, alpha: float = 1.0
    ) -> None:
        """Add polylines as one marker; none if there are no points."""
        points = [_xyz(*end) for way in ways for piece in pairwise(way) for end in piece]
        if points:
            looks = {"scale": _xyz(width * self.unit), "color": {**colour(paint), "a": alpha}, "points": points}
            self._add(MAP, ns, type=Marker.LINE_LIST, pose=self._pose((0.0, 0.0), z), **looks)

    def _pose(self, at: Point, z: float) -> dict[str, Any]:
        return {"position": _xyz(at[0], at[1], z * self.unit * self._up), "orientation": _FLAT}

    def _add(self, frame: str, ns: str, **values: Any) -> None:
        self._markers.append(self._marker(frame, ns, id=len(self._markers), **values))

    def _marker(self, frame: str, ns: str, **values: Any) -> dict[str, Any]:
        return {**_blank(), "header": {"stamp": self._stamp, "frame_id": frame}, "ns": ns, **values}


@cache
def _blank() -> dict[str, Any]:
    return Marker().model_dump()


@cache
def _palette() -> dict[str, Any]:
    palette: dict[str, Any] = json.loads(files("hmrsim.drawing").joinpath("palette.json").read_text("utf-8"))
    return palette


@cache
def colour(name: str) -> dict[str, float]:
    """Return a colour of the palette as a ColorRGBA."""
    return _rgba(_palette()["light"][name])


def colour_of_type(types: Sequence[str], name: str) -> dict[str, float]:
    """Return the colour of a robot type; types that the world does not define share the last colour."""
    paints = _palette()["types"]
    return _rgba(paints[types.index(name) % len(paints) if name in types else -1])


def _rgba(text: str) -> dict[str, float]:
    red, green, blue = (int(text[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return {"r": red, "g": green, "b": blue, "a": 1.0}


def _xyz(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> dict[str, float]:
    return {"x": x, "y": y, "z": z}
