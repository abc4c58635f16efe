"""The robots and items that robots' sensors detect."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Collection, Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from hmrsim.components import Sensor
from hmrsim.engine.internal_errors import BUGS
from hmrsim.geometry import Pose, distance, turn
from hmrsim.interfaces.vision_msgs import Detection3DArray
from hmrsim.items import Item
from hmrsim.protocol.outputs import Sampled
from hmrsim.protocol.topics import Topic

if TYPE_CHECKING:
    from hmrsim.engine.internal_errors import InternalErrors
    from hmrsim.robots.robot import Robot
    from hmrsim.simulation.entities import Roster

_SAME_YAW = 0.1
"""Radians; an entity that turns by less is not published again."""


class Thing(NamedTuple):
    """A robot or an item that may be seen.

    Attributes:
        kind: The robot's type, or ``item``.
        size: Its footprint's diameter; 0 if it has none.
        carrier: The name of the robot that it is, or that carries it; that one does not see it.
    """

    pose: Pose
    name: str
    kind: str
    size: float
    carrier: str


class Seen(NamedTuple):
    """A thing that is seen.

    Attributes:
        by: The names of the sensors that see it.
    """

    thing: Thing
    by: tuple[str, ...]


class Surroundings:
    """The detectable entities at one instant, in order of x, so that a sensor checks a few of them only."""

    def __init__(self, roster: Roster) -> None:
        things = [_thing(robot) for robot in roster.robots.values()]
        self._things = sorted(things + [_thing(item) for item in roster.items.values()])
        self._xs = [thing.pose.x for thing in self._things]

    def near(self, pose: Pose, radius: float) -> list[Thing]:
        """Return the things within a distance, and some that are farther."""
        low, high = bisect_left(self._xs, pose.x - radius), bisect_right(self._xs, pose.x + radius)
        return [thing for thing in self._things[low:high] if abs(thing.pose.y - pose.y) <= radius]


class Detections:
    """Finds what the robots' sensors detect."""

    def __init__(self, roster: Roster, errors: InternalErrors) -> None:
        self._roster = roster
        self._errors = errors
        self._published: dict[str, Mapping[str, Pose]] = {}

    def look(self, robot: Robot, surroundings: Surroundings) -> list[Seen]:
        """Return the entities that a robot sees, in order of name, without itself and the items that it carries."""
        sensors = sensors_of(robot)
        reach = max((sensor.range(robot.units) for sensor in sensors.values() if not sensor.blind), default=None)
        if reach is None:
            return []
        here = robot.pose()
        seen = [
            Seen(thing, by)
            for thing in surroundings.near(here, reach)
            if thing.carrier != robot.name and (by := self._seen_by(robot, here, thing))
        ]
        return sorted(seen, key=lambda each: each.thing.name)

    def look_for(self, robot: Robot, entity: Robot | Item) -> Seen | None:
        """Return the detection of an entity by a robot; None if the robot does not see it."""
        thing = _thing(entity)
        by = self._seen_by(robot, robot.pose(), thing) if thing.carrier != robot.name else ()
        return Seen(thing, by) if by else None

    def _seen_by(self, robot: Robot, here: Pose, thing: Thing) -> tuple[str, ...]:
        there = thing.pose.point
        looking = {
            name: sensor
            for name, sensor in sensors_of(robot).items()
            if not sensor.blind and sensor.covers(here, there, robot.units)
        }
        if not looking:
            return ()
        hidden = not self._roster.admission.graph.clear_now(here.point, there)
        return tuple(name for name, sensor in looking.items() if sensor.through_walls or not hidden)

    def message(self, robot: Robot, seen: list[Seen]) -> Sampled:
        """Return a robot's detections, placed according to its own pose estimate."""
        header = robot.stamped(robot.pose())["header"]
        found = {"header": header, "detections": [_detection(header, robot, each.thing) for each in seen]}
        return Sampled(Topic.DETECTIONS, robot.name, Detection3DArray.model_validate(found))

    def changed(self, silent: Collection[str]) -> Iterator[Sampled]:
        """Yield the detections of robots that have changed since they were published, except of *silent* robots."""
        robots = self._roster.robots.values()
        watchers = [robot for robot in robots if robot.name not in silent and sensors_of(robot)]
        surroundings = Surroundings(self._roster) if watchers else None
        before, self._published = self._published, {}
        for robot in watchers:
            if surroundings is None:
                raise AssertionError
            known = before.get(robot.name)
            try:
                seen = self.look(robot, surroundings)
                now = {each.thing.name: robot.estimated(each.thing.pose) for each in seen}
                same = known is not None and not _differ(known, now, _resolution(robot))
            except BUGS as bug:
                self._errors.handle("a sensor", bug, robot.name, replayed=False)
                continue
            if known is not None and same:
                self._published[robot.name] = known
                continue
            self._published[robot.name] = now
            yield self.message(robot, seen)

    def forget(self) -> None:
        """Publish all detections again to the next subscriber."""
        self._published.clear()


def sensors_of(robot: Robot) -> dict[str, Sensor]:
    """Return a robot's sensors by the names of the components."""
    return {name: one for name, one in robot.components.items() if isinstance(one, Sensor)}


def _thing(entity: Robot | Item) -> Thing:
    if isinstance(entity, Item):
        carrier = entity.carrier.name if entity.carrier else ""
        return Thing(Pose(*entity.position), entity.name, "item", 0.0, carrier)
    return Thing(entity.pose(), entity.name, entity.type, 2 * entity.radius, entity.name)


def _resolution(robot: Robot) -> float:
    return min(sensor.resolution(robot.units) for sensor in sensors_of(robot).values())


def _differ(known: Mapping[str, Pose], now: Mapping[str, Pose], resolution: float) -> bool:
    return known.keys() != now.keys() or any(
        distance(known[name].point, pose.point) > resolution or abs(turn(known[name].yaw, pose.yaw)) > _SAME_YAW
        for name, pose in now.items()
    )


def _detection(header: dict[str, Any], robot: Robot, thing: Thing) -> dict[str, Any]:
    pose = robot.stamped(robot.estimated(thing.pose))["pose"]
    hypothesis = {"class_id": thing.kind, "score": 1.0}
    return {
        "header": header,
        "results": [{"hypothesis": hypothesis, "pose": {"pose": pose}}],
        "bbox": {"center": pose, "size": {"x": thing.size, "y": thing.size}},
        "id": thing.name,
    }
