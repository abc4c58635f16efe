"""The state of the world as signals, such as a robot's nearness to a place; only requested signals are updated."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Hashable, Mapping, Sequence
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

from hmrsim.events.robots import MotionBegan, Stopped
from hmrsim.events.simulation import Deleted, Spawned, Teleported
from hmrsim.events.traffic import MadeRoom, Waiting
from hmrsim.geometry import distance
from hmrsim.history.history import History
from hmrsim.history.motion import Motion, Span, closest, motion_in, spans_near
from hmrsim.history.occurrence import SceneSeen, point, records, text
from hmrsim.history.timeline import Phase
from hmrsim.interfaces.simulation_interfaces import ResetSimulation
from hmrsim.properties.signals import FAILS, HOLDS, Signal, pulse
from hmrsim.simulation.demand import NEAR

if TYPE_CHECKING:
    from hmrsim.events import EventPattern
    from hmrsim.geometry import Point
    from hmrsim.history.facilities import Doors
    from hmrsim.history.items import Orders
    from hmrsim.history.robots import Robots
    from hmrsim.history.timeline import Alarm, Part, Timeline
    from hmrsim.properties.results import ItemEnd, Reference
    from hmrsim.world.model import World


def point_of(world: World, place: str) -> Point | None:
    """Return the position of a place, dock or waypoint; None if the world has none of this name."""
    try:
        return world.point(place)
    except KeyError:
        return None


class _Near:
    """The nearness of a robot to a place, now and during its current motions.

    Attributes:
        spans: When it is near, from now on.
        alarm: Rings at the next change of the signal; None if no change is known.
        closest: The least distance so far.
    """

    def __init__(self, place: Point) -> None:
        self.place = place
        self.signal = Signal()
        self.spans: list[Span] = []
        self.alarm: Alarm | None = None
        self.closest = math.inf


class Positions:
    """Follows the positions of the robots of a world."""

    def __init__(self, world: World, timeline: Timeline) -> None:
        self._world, self._timeline = world, timeline
        self._radius = NEAR[world.units]
        self._at: dict[str, Point | None] = {}
        self._motions: dict[str, Sequence[Motion] | None] = {}
        self._near: dict[str, dict[str, _Near]] = {}
        # The last motion of each robot for which no place has been requested yet.
        self._deferred: dict[str, tuple[int, MotionBegan]] = {}
        self._reset(0)
        timeline.on_reset(ResetSimulation.Request.SCOPE_STATE, self._reset)
        timeline.on(MotionBegan, self._on_motion)
        timeline.on((Stopped, Waiting), lambda _at, event: self._stand(event.robot, event.at))
        timeline.on(MadeRoom, lambda _at, event: self._stand(event.robot, event.from_))
        timeline.on((Teleported, Spawned), self._on_placement)
        timeline.on(Deleted, lambda _at, event: self._stand(event.entity, None))
        timeline.on(SceneSeen, self._on_scene)

    def near(self, robot: str, place: str) -> Signal:
        """Return the signal that holds while a robot is near a place."""
        places = self._near.setdefault(robot, {})
        if place not in places:
            position = point_of(self._world, place)
            if position is None:
                return Signal()
            if robot in self._deferred:
                self._move(robot, Motion.all_of(*self._deferred.pop(robot)))
            near = places[place] = _Near(position)
            self._predict(robot, near)
        return places[place].signal

    def clearance(self, robot: str, place: str) -> float:
        """Return the least distance of a robot from the circle around a place so far, in radii; negative inside."""
        near = self._near.get(robot, {}).get(place)
        if near is None:
            return math.inf
        self._measure(robot, near)
        return (near.closest - self._radius) / self._radius

    def _measure(self, robot: str, near: _Near) -> None:
        """Update the least distance of a robot to a place."""
        motions, position = self._motions.get(robot), self._at.get(robot)
        if motions is not None:
            near.closest = min(near.closest, closest(near.place, motions, self._timeline.now))
        elif position is not None:
            near.closest = min(near.closest, distance(position, near.place))

    def _reset(self, _now: int) -> None:
        """Return all robots to their initial positions."""
        for name in [*self._at]:
            if name not in self._world.robots:
                self._stand(name, None)
        for name, robot in self._world.robots.items():
            self._stand(name, self._world.point(robot.at))

    def _on_placement(self, _at: int, event: Teleported | Spawned) -> None:
        if event.entity in self._at or (isinstance(event, Spawned) and event.type != "item"):
            self._stand(event.entity, event.at)

    def _stand(self, robot: str, position: Point | None) -> None:
        """Record that a robot stands at a position, or at none if it was deleted."""
        self._deferred.pop(robot, None)
        self._set(robot, position, None)

    def _on_motion(self, at: int, event: MotionBegan) -> None:
        if event.robot in self._near:
            self._move(event.robot, Motion.all_of(at, event))
        else:
            self._deferred[event.robot] = at, event

    def _move(self, robot: str, motions: Sequence[Motion]) -> None:
        """Record that a robot is carrying out some motions."""
        self._set(robot, motions[-1].end, motions)

    def _set(self, robot: str, position: Point | None, motions: Sequence[Motion] | None) -> None:
        places = self._near.get(robot, {}).values()
        for near in places:
            self._measure(robot, near)
        self._at[robot], self._motions[robot] = position, motions
        for near in places:
            self._predict(robot, near)

    def _predict(self, robot: str, near: _Near) -> None:
        """Find out when a robot is near a place from now on, and set the signal."""
        if near.alarm is not None:
            near.alarm.cancel()
        motions, position = self._motions.get(robot), self._at.get(robot)
        if motions is not None:
            near.spans = spans_near(near.place, self._radius, motions)
        else:
            inside = position is not None and distance(position, near.place) <= self._radius
            near.spans = [(self._timeline.now, None)] if inside else []
        self._set_signal(near)

    def _set_signal(self, near: _Near) -> None:
        """Set the signal for now, and an alarm for its next change."""
        now = self._timeline.now
        while near.spans and (leaves := near.spans[0][1]) is not None and leaves < now:
            near.spans.pop(0)
        near.alarm = None
        if not near.spans:
            near.signal.set(FAILS)
            return
        enters, leaves = near.spans[0]
        inside = enters <= now
        near.signal.set(HOLDS if inside else FAILS)
        due = (None if leaves is None else leaves + 1) if inside else enters
        if due is not None:
            near.alarm = self._timeline.alarm(due, Phase.CHANGE, lambda _at: self._set_signal(near))

    def _on_scene(self, at: int, scene: SceneSeen) -> None:
        robots = records(scene.fields, "robots")
        names = {text(robot, "name") for robot in robots}
        for name in [*self._at]:
            if name not in names:
                self._stand(name, None)
        for robot in robots:
            self._on_robot(at, robot)

    def _on_robot(self, at: int, robot: Mapping[str, Any]) -> None:
        motion = motion_in(robot, at, self._timeline.offset)
        if motion is None:
            self._stand(text(robot, "name"), point(robot, "pose"))
        else:
            self._move(text(robot, "name"), Motion.all_of(*motion))


class Observations:
    """The signals of a run.

    Attributes:
        reference: The items at the end of the run without faults; None if there is none to compare with.
    """

    def __init__(self, world: World, timeline: Timeline, reference: Reference | None = None) -> None:
        self.world, self.timeline, self.reference = world, timeline, reference
        self.history = History(timeline, world)
        self._radius = NEAR[world.units]
        self._signals: dict[Hashable, Signal] = {}
        self._pulses: list[tuple[EventPattern, Signal]] = []

    @cached_property
    def positions(self) -> Positions:
        """The positions of the robots over time."""
        return Positions(self.world, self.timeline)

    @property
    def watched_batteries(self) -> Collection[str]:
        """The robots whose batteries are watched; a view, as more may be added later."""
        return self.history.batteries.shares.keys() if "batteries" in vars(self.history) else ()

    def is_(self, part: Doors | Orders | Robots, name: str, state: str) -> Signal:
        """Return whether a door, order or robot is in a state; a jammed door and a late order are also in another."""
        return self.whether(part, name, state, partial(part.is_, name, state))

    def battery_share(self, robot: str) -> Signal:
        """Return the remaining share of a robot's battery; 1 without a battery."""
        batteries = self.history.batteries
        batteries.follow(robot)
        return self._value(batteries, robot, "share", partial(batteries.shares.__getitem__, robot))

    def item_lies_at(self, item: str, place: str) -> Signal:
        """Return whether an item lies at a place, and no robot carries it."""
        where = point_of(self.world, place)
        return self.whether(
            self.history.items, item, f"lies at {place}", lambda: where is not None and self._lies_near(item, where)
        )

    def item_is_as_in(self, item: str, end: ItemEnd) -> Signal:
        """Return whether an item is where it was at the end of another run: near the point, or carried as there."""
        items = self.history.items
        return self.whether(
            items, item, end, lambda: bool(items[item].carrier) if end.carried else self._lies_near(item, end.at)
        )

    def item_is_carried(self, item: str, by: str | None) -> Signal:
        """Return whether an item is carried, by a robot or by any."""
        items = self.history.items
        return self.whether(
            items, item, f"carried by {by}", lambda: bool(items[item].carrier) and by in (None, items[item].carrier)
        )

    def item_is_at(self, item: str, place: str) -> Signal:
        """Return whether an item is at a place, where it lies or is carried."""
        items, lies, carriers = self.history.items, self.item_lies_at(item, place), dict[str, Signal]()

        def follow(robot: str) -> None:
            carriers[robot] = self.positions.near(robot, place)
            carriers[robot].subscribe(lambda: found.set(value()))

        def value() -> float:
            carrier = items[item].carrier
            if not carrier:
                return lies.value
            if carrier not in carriers:
                follow(carrier)
            return carriers[carrier].value

        found = self._value(items, item, f"at {place}", value)
        # Where a robot is when it picks up the item follows from its motion until then.
        for name, robot in self.world.robots.items():
            if name not in carriers and "claw" in self.world.robot_type(robot).components:
                follow(name)
        return found

    def pulse(self, pattern: EventPattern) -> Signal:
        """Return a signal that holds at the instants of some events."""
        known = next((signal for each, signal in self._pulses if each == pattern), None)
        if known is None:
            known = pulse(self.timeline, pattern)
            self._pulses.append((pattern, known))
        return known

    def _lies_near(self, item: str, where: Point) -> bool:
        known = self.history.items[item]
        return not known.carrier and known.at is not None and distance(known.at, where) <= self._radius

    def whether(self, part: Part, name: Hashable, what: Hashable, holds: Callable[[], bool]) -> Signal:
        """Return the signal of whether something holds for a member of a part."""
        return self._value(part, name, what, lambda: HOLDS if holds() else FAILS)

    def _value(self, part: Part, name: Hashable, what: Hashable, value: Callable[[], float]) -> Signal:
        key = part, name, what
        signal = self._signals.get(key)
        if signal is None:
            signal = self._signals[key] = Signal(value())
            part.watch(name, lambda: signal.set(value()))
        return signal
