"""Where robots are: near which places, also while they pass them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from hmrsim.events.robots import MotionBegan, Stopped
from hmrsim.events.simulation import Deleted, Spawned, Teleported
from hmrsim.events.traffic import MadeRoom, Waiting
from hmrsim.geometry import distance
from hmrsim.history.motion import Motion, Span, closest, motion_in, spans_near
from hmrsim.history.occurrence import SceneSeen, point, records, text
from hmrsim.history.timeline import Phase
from hmrsim.interfaces.simulation_interfaces import ResetSimulation
from hmrsim.properties.observing.signal import FAILS, HOLDS, Signal
from hmrsim.simulation.demand import NEAR

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.history.timeline import Alarm, Timeline
    from hmrsim.world.model import World


def point_of(world: World, place: str) -> Point | None:
    """Return where a place, dock or waypoint is; None if there is none, as an event may name anything."""
    try:
        return world.point(place)
    except KeyError:
        return None


class _Near:
    """Whether a robot is near a place, now and as it is going to drive."""

    def __init__(self, place: Point) -> None:
        self.place = place
        self.signal = Signal()
        self.coming: list[Span] = []
        self.alarm: Alarm | None = None
        self.closest = math.inf


class Positions:
    """Follows the robots of a world."""

    def __init__(self, world: World, timeline: Timeline) -> None:
        self._world, self._timeline = world, timeline
        self._radius = NEAR[world.units]
        self._at: dict[str, Point | None] = {}
        self._motions: dict[str, Sequence[Motion]] = {}
        self._near: dict[str, dict[str, _Near]] = {}
        self._told: dict[str, tuple[int, MotionBegan]] = {}
        self._begin_anew(0)
        timeline.on_reset(ResetSimulation.Request.SCOPE_STATE, self._begin_anew)
        timeline.on(MotionBegan, self._move)
        for stops in (Stopped, Waiting):
            timeline.on(stops, lambda at, event: self._stand(at, event.robot, event.at))
        timeline.on(MadeRoom, lambda at, event: self._stand(at, event.robot, event.from_))
        for put in (Teleported, Spawned):
            timeline.on(put, self._put)
        timeline.on(Deleted, lambda at, event: self._stand(at, event.entity, None))
        timeline.on(SceneSeen, self._see)

    def near(self, robot: str, place: str) -> Signal:
        """Return whether a robot is at a place."""
        places = self._near.setdefault(robot, {})
        if place not in places:
            where = point_of(self._world, place)
            if where is None:
                return Signal()
            if robot in self._told:
                self._go(robot, Motion.all_of(*self._told.pop(robot)))
            near = places[place] = _Near(where)
            self._look(robot, near)
        return places[place].signal

    def clearance(self, robot: str, place: str) -> float:
        """Return how far from being at a place a robot was at least, in radii of the circle around it."""
        near = self._near.get(robot, {}).get(place)
        if near is None:
            return math.inf
        self._measure(robot, near)
        return (near.closest - self._radius) / self._radius

    def _measure(self, robot: str, near: _Near) -> None:
        """Take note of how near a robot has come since it was last looked at."""
        motions, where = self._motions.get(robot), self._at.get(robot)
        if motions is not None:
            near.closest = min(near.closest, closest(near.place, motions, self._timeline.now))
        elif where is not None:
            near.closest = min(near.closest, distance(where, near.place))

    def _begin_anew(self, now: int) -> None:
        """Return all robots to their initial positions."""
        for name in [*self._at]:
            if name not in self._world.robots:
                self._stand(now, name, None)
        for name, robot in self._world.robots.items():
            self._stand(now, name, self._world.point(robot.at))

    def _put(self, at: int, event: Teleported | Spawned) -> None:
        if event.entity in self._at or (isinstance(event, Spawned) and event.type != "item"):
            self._stand(at, event.entity, event.at)

    def _stand(self, _at: int, robot: str, where: Point | None) -> None:
        for near in self._near.get(robot, {}).values():
            self._measure(robot, near)
        self._at[robot] = where
        self._motions.pop(robot, None)
        self._told.pop(robot, None)
        for near in self._near.get(robot, {}).values():
            self._look(robot, near)

    def _move(self, at: int, event: MotionBegan) -> None:
        if event.robot in self._near:
            self._go(event.robot, Motion.all_of(at, event))
        else:
            # Nobody has asked where it is yet.
            self._told[event.robot] = at, event

    def _go(self, robot: str, motions: Sequence[Motion]) -> None:
        for near in self._near.get(robot, {}).values():
            self._measure(robot, near)
        self._motions[robot] = motions
        self._at[robot] = motions[-1].end
        for near in self._near.get(robot, {}).values():
            self._look(robot, near)

    def _look(self, robot: str, near: _Near) -> None:
        """Work out whether a robot is at a place now, and when that changes."""
        if near.alarm is not None:
            near.alarm.cancel()
        motions, where = self._motions.get(robot), self._at.get(robot)
        if motions is not None:
            near.coming = spans_near(near.place, self._radius, motions)
        else:
            there = where is not None and distance(where, near.place) <= self._radius
            near.coming = [(self._timeline.now, None)] if there else []
        self._follow(near)

    def _follow(self, near: _Near) -> None:
        """Set the signal for now, and wait for its next change."""
        now = self._timeline.now
        while near.coming and (ended := near.coming[0][1]) is not None and ended < now:
            near.coming.pop(0)
        near.alarm = None
        if not near.coming:
            near.signal.set(FAILS)
            return
        began, ended = near.coming[0]
        inside = began <= now
        near.signal.set(HOLDS if inside else FAILS)
        due = (None if ended is None else ended + 1) if inside else began
        if due is not None:
            near.alarm = self._timeline.alarm(due, Phase.CHANGE, lambda _at: self._follow(near))

    def _see(self, at: int, scene: SceneSeen) -> None:
        said = records(scene.fields, "robots")
        there = {text(robot, "name") for robot in said}
        for name in [*self._at]:
            if name not in there:
                self._stand(at, name, None)
        for robot in said:
            self._see_robot(at, robot)

    def _see_robot(self, at: int, robot: Mapping[str, Any]) -> None:
        moving = motion_in(robot, at, self._timeline.offset)
        if moving is None:
            self._stand(at, text(robot, "name"), point(robot, "pose"))
        else:
            self._go(text(robot, "name"), Motion.all_of(*moving))
