"""Markers of a world and its contents, for RViz and Foxglove, as plain values: much faster than messages.

Their frame is ``map``. Robots and carried items are in the robots' frames. In a world in pixels 1 px becomes 1 m, and y
points down. ``map`` is then upside down in a further frame ``world``, which shows the same view as the page.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from importlib.resources import files
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final

from hmrsim.history.facilities import Doors, Lanes
from hmrsim.history.items import Items
from hmrsim.history.occurrence import Occurrence, SceneSeen
from hmrsim.history.timeline import Timeline
from hmrsim.interfaces.builtin_interfaces import values_of
from hmrsim.interfaces.visualization_msgs import Marker
from hmrsim.world.model import World
from hmrsim.world_checks.resolved import type_order

if TYPE_CHECKING:
    from hmrsim.events import Event

    Point = Sequence[float]

MAP, BASE = "map", "base_link"
"""The frames of static objects, and of a robot below its name."""

UP: Final = {"m": 1.0, "px": -1.0}
"""The direction of z, by the unit of the world: with y down, the frame is upside down."""

_FLAT: Final = {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}
_HALF_ROUND: Final = {"x": 1.0, "y": 0.0, "z": 0.0, "w": 0.0}
"""Half a turn about the x axis."""

_TEXT_HEIGHT: Final = 0.3
_THIN: Final = 0.15
"""An arrow's width relative to its length."""


class MarkerBuilder:
    """Collects markers that replace all earlier ones.

    Args:
        time: The stamp in nanoseconds.
        unit: About a meter in the world's unit; all sizes and heights are in meters.
        up: 1, or -1 in a frame that is upside down.
    """

    def __init__(self, time: int, *, unit: float = 1.0, up: float = 1.0) -> None:
        self._stamp = values_of(time)
        self._up = up
        self.unit = unit
        self._markers: list[dict[str, Any]] = [self._marker(MAP, "", action=Marker.DELETEALL)]

    def message(self) -> dict[str, Any]:
        """Return all markers as a MarkerArray."""
        return {"markers": self._markers}

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
            scale=xyz(size, width, tall),
            color=color(paint) if isinstance(paint, str) else paint,
            frame_locked=frame != MAP,
        )

    def text(self, ns: str, text: str, at: Point, *, z: float = 0.4, frame: str = MAP) -> None:
        """Add a label above a point."""
        scale = xyz(z=_TEXT_HEIGHT * self.unit)
        looks = {"scale": scale, "color": color("muted"), "text": text, "frame_locked": frame != MAP}
        self._add(frame, ns, type=Marker.TEXT_VIEW_FACING, pose=self._pose(at, z), **looks)

    def lines(
        self, ns: str, ways: Iterable[Sequence[Point]], width: float, paint: str, *, z: float = 0.0, alpha: float = 1.0
    ) -> None:
        """Add polylines as one marker; none if there are no points."""
        points = [xyz(*end) for way in ways for piece in pairwise(way) for end in piece]
        if points:
            looks = {"scale": xyz(width * self.unit), "color": {**color(paint), "a": alpha}, "points": points}
            self._add(MAP, ns, type=Marker.LINE_LIST, pose=self._pose((0.0, 0.0), z), **looks)

    def _pose(self, at: Point, z: float) -> dict[str, Any]:
        return {"position": xyz(at[0], at[1], z * self.unit * self._up), "orientation": _FLAT}

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
def color(name: str) -> dict[str, float]:
    """Return a color of the palette as a ColorRGBA."""
    return _rgba(_palette()["light"][name])


def color_of_type(types: Sequence[str], name: str) -> dict[str, float]:
    """Return the color of a robot type; types that the world does not define share the last color."""
    paints = _palette()["types"]
    return _rgba(paints[types.index(name) % len(paints) if name in types else -1])


def _rgba(text: str) -> dict[str, float]:
    red, green, blue = (int(text[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return {"r": red, "g": green, "b": blue, "a": 1.0}


def xyz(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> dict[str, float]:
    """Return the values of a Point or a Vector3."""
    return {"x": x, "y": y, "z": z}


def transform(header: Any, child: str, translation: Any, rotation: Any = _FLAT) -> dict[str, Any]:
    """Return a TransformStamped; by default without a rotation."""
    return {
        "header": header,
        "child_frame_id": child,
        "transform": {"translation": translation, "rotation": rotation},
    }


_WORLD: Final = "world"

_UNIT: Final = {"m": 1.0, "px": 40.0}
"""About a meter in the world's unit, for objects without a size."""


def static_frames(units: str, time: int) -> list[dict[str, Any]]:
    """Return the transform in which ``map`` is upside down in ``world``; none in a world in meters.

    Args:
        units: The unit of the world.
        time: The stamp in nanoseconds.
    """
    if units == "m":
        return []
    return [transform({"stamp": values_of(time), "frame_id": _WORLD}, MAP, xyz(), _HALF_ROUND)]


def frames_metadata(units: str) -> dict[str, str]:
    """Return the metadata of the frames of a world in these units."""
    if units == "m":
        return {"frames": f"{MAP}, in meters, y up"}
    return {"frames": f"{MAP}, 1 px as 1 m, y down; {_WORLD}, in which {MAP} is upside down: look at it from above"}


class WorldMarkers:
    """Makes markers, in two arrays: `markers` for static and `things` for moving objects."""

    def __init__(self) -> None:
        self._robots: list[Mapping[str, Any]] = []
        self._changed = False
        self.load(World())

    def load(self, world: World) -> None:
        """Draw another world from now on; a scene has to follow."""
        self._world = world
        # Only the order of its events counts.
        timeline = self._timeline = Timeline()
        self._items, self._doors, self._lanes = Items(timeline, world), Doors(timeline, world), Lanes(timeline)
        for part in (self._items, self._doors, self._lanes):
            part.watch_all(self._mark)

    def follow(self, scene: Mapping[str, Any]) -> None:
        """Replace the state by a scene."""
        self._robots = scene["robots"]
        self._timeline.take(Occurrence(0, SceneSeen(scene)))

    def change(self, event: Event) -> bool:
        """Apply an event; return whether `things` has changed."""
        self._changed = False
        self._timeline.take(Occurrence(0, event))
        return self._changed

    def _mark(self, _name: object) -> None:
        self._changed = True

    def markers(self, time: int) -> dict[str, Any]:
        """Return the static objects and the robots' bodies."""
        builder = self._builder(time)
        self._draw_ground(builder)
        for name, place in self._world.places.items():
            builder.at("places", Marker.SPHERE, place.at, 0.15, "place")
            builder.text("places", name, place.at)
        for name, dock in self._world.docks.items():
            at = self._world.dock_point(name)
            builder.at("docks", Marker.CUBE, at, 0.5, "charger" if dock.charges else "dock", z=-0.25)
            builder.text("docks", name, at)
        for name, lift in self._world.lifts.items():
            for stop in lift.stops:
                builder.at("lifts", Marker.CUBE, self._world.point(stop), 0.8, "lift", z=-0.4)
                builder.text("lifts", name, self._world.point(stop))
        types = type_order(self._world)
        for robot in self._robots:
            self._draw_robot(builder, robot, color_of_type(types, robot["type"]))
        return builder.message()

    def things(self, time: int) -> dict[str, Any]:
        """Return items, doors and closed lanes."""
        builder = self._builder(time)
        for name, item in self._items.present():
            if item.carrier or item.at is None:
                builder.at("items", Marker.SPHERE, (0.0, 0.0), 0.25, "item", z=0.5, frame=f"{item.carrier}/{BASE}")
            else:
                builder.at("items", Marker.SPHERE, item.at, 0.25, "item", z=0.1)
                builder.text("items", name, item.at)
        for name, door in self._world.doors.items():
            shut = not self._doors.is_(name, "open")
            builder.lines("doors", [door.at], 0.12, "door", alpha=1.0 if shut else 0.25, z=0.1)
        points = self._world.points
        closed = [(points[a], points[b]) for a, b in self._lanes.closed() if a in points and b in points]
        builder.lines("closed lanes", closed, 0.12, "lane_closed", z=0.05)
        return builder.message()

    def _builder(self, time: int) -> MarkerBuilder:
        units = self._world.units
        return MarkerBuilder(time, unit=_UNIT[units], up=UP[units])

    def _draw_ground(self, builder: MarkerBuilder) -> None:
        points = self._world.points
        builder.lines("lanes", [(points[lane.from_], points[lane.to]) for lane in self._world.lanes], 0.04, "lane")
        builder.lines("walls", self._world.outlines, 0.1, "wall", z=0.1)

    def _draw_robot(self, builder: MarkerBuilder, robot: Mapping[str, Any], painted: Mapping[str, float]) -> None:
        frame = f"{robot['name']}/{BASE}"
        across = 2 * robot["radius"] / builder.unit if robot["radius"] else 0.6
        center = (0.0, 0.0)
        builder.at("robots", Marker.CYLINDER, center, across, painted, z=0.1, high=0.2, frame=frame)
        builder.at("robots", Marker.ARROW, center, across * 0.7, "robot_outline", z=0.25, high=0.1, frame=frame)
        builder.text("robots", robot["name"], center, z=0.6, frame=frame)
