"""Markers of a world and its contents, for RViz and Foxglove.

Their frame is ``map``; robots and carried items are in the robots' frames. In a world in pixels 1 px becomes 1 m, and y
points down; ``map`` is then upside down in a further frame ``world``, which shows the same view as the page.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final

from hmrsim.events.facilities import DoorClosed, DoorOpened, DoorOpening
from hmrsim.events.robots import ItemDropped, ItemPicked, ItemPlaced
from hmrsim.events.traffic import LaneClosed, LaneOpened
from hmrsim.interfaces.visualization_msgs import Marker
from hmrsim.world.model import Solid, World
from hmrsim.world_checks.resolved import type_order
from hmrsim_zenoh.recording.marking import MAP, Marking, colour_of_type

if TYPE_CHECKING:
    from hmrsim.events import Event

_WORLD: Final = "world"

_UNIT: Final = {"m": 1.0, "px": 40.0}
"""About a metre in the world's unit, for objects without a size."""

_DOORS: Final[Mapping[type[Event], str]] = {DoorOpening: "opening", DoorOpened: "open", DoorClosed: "closed"}
"""The state of a door after each event."""


def looked_at_from_above(units: str) -> dict[str, str]:
    """Return the metadata of the frames of a world in these units."""
    if units == "m":
        return {"frames": f"{MAP}, in metres, y up"}
    return {"frames": f"{MAP}, 1 px as 1 m, y down; {_WORLD}, in which {MAP} is upside down: look at it from above"}


class Pictures:
    """Makes markers, in two arrays: `markers` for what rarely changes and `things` for what often does."""

    def __init__(self) -> None:
        self._world = World()
        self._robots: list[Mapping[str, Any]] = []
        self._items: dict[str, dict[str, Any]] = {}
        self._doors: dict[str, str] = {}
        self._closed: dict[tuple[str, str], str] = {}

    def load(self, definition: Mapping[str, Any]) -> None:
        """Replace the world."""
        self._world = World.model_validate(definition)

    def follow(self, scene: Mapping[str, Any]) -> None:
        """Replace the state by a scene."""
        self._robots = scene["robots"]
        self._items = {item["name"]: dict(item) for item in scene["items"]}
        doors = (fixture for fixture in scene["fixtures"] if fixture["kind"] == "door")
        self._doors = {door["name"]: "open" if "open" in door["tags"] else "closed" for door in doors}
        self._closed = {(lane["lane"][0], lane["lane"][1]): lane["why"] for lane in scene["closed_lanes"]}

    def change(self, event: Event) -> bool:
        """Apply an event; return whether `things` has changed."""
        match event:
            case ItemPicked(robot, name) if name in self._items:
                self._items[name]["carrier"] = robot
            case ItemPlaced(_, name, at) | ItemDropped(_, name, at) if name in self._items:
                self._items[name].update(carrier=None, at=at)
            case DoorOpening() | DoorOpened() | DoorClosed() if self._doors.get(event.door) != _DOORS[type(event)]:
                self._doors[event.door] = _DOORS[type(event)]
            case LaneClosed(lane, why):
                self._closed[lane] = why
            case LaneOpened(lane):
                self._closed.pop(lane, None)
            case _:
                return False
        return True

    def frames(self, time: int) -> dict[str, Any] | None:
        """Return the static transforms; None if there is only one frame."""
        if self._world.units == "m":
            return None
        return Marking(time).upside_down(_WORLD, MAP)

    def markers(self, time: int) -> dict[str, Any]:
        """Return the static objects and the robots' bodies."""
        marking = self._marking(time)
        self._draw_ground(marking)
        for name, place in self._world.places.items():
            marking.at("places", Marker.SPHERE, place.at, 0.15, "place")
            marking.text("places", name, place.at)
        for name, dock in self._world.docks.items():
            at = self._world.dock_point(name)
            marking.at("docks", Marker.CUBE, at, 0.5, "charger" if dock.charges else "dock", z=-0.25)
            marking.text("docks", name, at)
        for name, lift in self._world.lifts.items():
            for stop in lift.stops:
                marking.at("lifts", Marker.CUBE, self._world.point(stop), 0.8, "lift", z=-0.4)
                marking.text("lifts", name, self._world.point(stop))
        types = type_order(self._world)
        for robot in self._robots:
            self._draw_robot(marking, robot, colour_of_type(types, robot["type"]))
        return marking.array()

    def things(self, time: int) -> dict[str, Any]:
        """Return items, doors and closed lanes."""
        marking = self._marking(time)
        for name, item in self._items.items():
            carrier = item["carrier"]
            at, frame = ((0.0, 0.0), f"{carrier}/base_link") if carrier else (item["at"], MAP)
            marking.at("items", Marker.SPHERE, at, 0.25, "item", z=0.5 if carrier else 0.1, frame=frame)
            if not carrier:
                marking.text("items", name, at)
        for name, door in self._world.doors.items():
            shut = self._doors.get(name, "closed") != "open"
            marking.lines("doors", [door.at], 0.12, "door", alpha=1.0 if shut else 0.25, z=0.1)
        points = self._world.points
        closed = [(points[a], points[b]) for a, b in self._closed if a in points and b in points]
        marking.lines("closed lanes", closed, 0.12, "lane_closed", z=0.05)
        return marking.array()

    def _marking(self, time: int) -> Marking:
        units = self._world.units
        return Marking(time, unit=_UNIT[units], up=1.0 if units == "m" else -1.0)

    def _draw_ground(self, marking: Marking) -> None:
        points = self._world.points
        marking.lines("lanes", [(points[lane.from_], points[lane.to]) for lane in self._world.lanes], 0.04, "lane")
        walls = [wall.solid + wall.solid[:1] if isinstance(wall, Solid) else wall for wall in self._world.walls]
        marking.lines("walls", walls, 0.1, "wall", z=0.1)

    def _draw_robot(self, marking: Marking, robot: Mapping[str, Any], painted: Mapping[str, float]) -> None:
        frame = f"{robot['name']}/base_link"
        across = 2 * robot["radius"] / marking.unit if robot["radius"] else 0.6
        centre = (0.0, 0.0)
        marking.at("robots", Marker.CYLINDER, centre, across, painted, z=0.1, high=0.2, frame=frame)
        marking.at("robots", Marker.ARROW, centre, across * 0.7, "robot_outline", z=0.25, high=0.1, frame=frame)
        marking.text("robots", robot["name"], centre, z=0.6, frame=frame)
