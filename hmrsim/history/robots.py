"""The states of robots, in the words of reports, and the charge of their batteries."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final, Literal

from hmrsim.components.battery import BatterySettings
from hmrsim.events.faults import FaultBegan, FaultEnded
from hmrsim.events.robots import (
    BATTERIES,
    BatteryEmpty,
    BatteryRevived,
    ChargingBegan,
    ChargingEnded,
    Docked,
    DockQueued,
    MotionBegan,
    Stopped,
)
from hmrsim.events.simulation import Deleted, Spawned, Teleported
from hmrsim.events.traffic import MadeRoom, Rerouted, Waiting, WentOn
from hmrsim.history.motion import motion_in
from hmrsim.history.occurrence import BatterySeen, SceneSeen, number, records, text, whole
from hmrsim.history.timeline import GoalSeen, Part, Phase
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.protocol.goal import GoalStatus

if TYPE_CHECKING:
    from collections.abc import Mapping

    from hmrsim.events.robots import BatteryEvent
    from hmrsim.history.timeline import Alarm, Timeline
    from hmrsim.world.model import World

State = Literal["offline", "stopped", "waiting", "driving", "charging", "busy", "idle"]
"""The states of a robot; if several apply, the first one."""

STATES: tuple[State, ...] = ("offline", "stopped", "waiting", "driving", "charging", "busy", "idle")

_MAX_SECONDS: Final = 1e9
_EMPTY: Final = BatteryEmpty.kind
"""The cause for which a robot with an empty battery is disabled."""


@dataclass(slots=True)
class Condition:
    """The lasting condition of a robot: events change it, whatever the robot does.

    Attributes:
        disabled: The causes for which it can't do anything: names of faults, or an empty battery.
        cut_off: The faults by which it is offline.
    """

    disabled: dict[str, None] = field(default_factory=dict)
    cut_off: dict[str, None] = field(default_factory=dict)
    charging: bool = False

    def apply(self, event: FaultBegan | FaultEnded | BatteryEvent) -> None:
        """Apply an event of the robot."""
        match event:
            case FaultBegan() | FaultEnded():
                causes = {"breakdown": self.disabled, "messages_lost": self.cut_off}.get(event.fault)
                if causes is not None:
                    _set(causes, event.name, applies=isinstance(event, FaultBegan))
            case BatteryEmpty() | BatteryRevived():
                _set(self.disabled, _EMPTY, applies=isinstance(event, BatteryEmpty))
            case ChargingBegan() | ChargingEnded():
                self.charging = isinstance(event, ChargingBegan)

    def see(self, robot: Mapping[str, Any]) -> None:
        """Start from a robot in a scene, without its faults, which the scene lists separately."""
        ailments, battery = robot.get("ailments"), robot.get("battery")
        self.clear()
        _set(self.disabled, _EMPTY, applies=isinstance(ailments, dict) and _EMPTY in ailments)
        self.charging = isinstance(battery, dict) and bool(battery.get("charging"))

    def clear(self) -> None:
        """Return to the initial condition."""
        self.disabled.clear()
        self.cut_off.clear()
        self.charging = False

    def state(self, *, waits: bool, aside: bool, moves: bool, busy: bool) -> State:
        """Return the state of the robot; if several apply, the most important one.

        Args:
            waits: Whether something blocks its way.
            aside: Whether it has made room for another robot.
            moves: Whether it drives, turns, or rides a lift.
            busy: Whether a goal executes.
        """
        if self.cut_off:
            return "offline"
        if self.disabled:
            return "stopped"
        if waits or (aside and busy and not moves):
            return "waiting"
        if moves:
            return "driving"
        if self.charging:
            return "charging"
        return "busy" if busy else "idle"


def _set(causes: dict[str, None], cause: str, *, applies: bool) -> None:
    if applies:
        causes[cause] = None
    else:
        causes.pop(cause, None)


@dataclass(slots=True)
class Robot:
    """A robot's state at the current time of the history.

    Attributes:
        queues: Whether it is in the queue of a dock, where it stays if it makes room.
        aside: Whether it has made room for another robot during a goal that still runs.
        arrives: Rings at the end of its motion; None while it stands.
    """

    present: bool = True
    condition: Condition = field(default_factory=Condition)
    waits: bool = False
    queues: bool = False
    aside: bool = False
    running: dict[str, None] = field(default_factory=dict)
    arrives: Alarm | None = None
    state: State = "idle"


class Robots(Part):
    """The states of the robots of a run, watched by name."""

    def __init__(self, timeline: Timeline, world: World) -> None:
        super().__init__()
        self._world, self._timeline = world, timeline
        self._robots = {name: Robot() for name in world.robots}
        timeline.on(GoalSeen, self._goal)
        timeline.on(MotionBegan, self._move)
        timeline.on(Stopped, lambda _at, event: self._stand(event.robot, waits=False))
        timeline.on(Waiting, lambda _at, event: self._stand(event.robot, waits=True))
        timeline.on((WentOn, Rerouted, MadeRoom), self._go_on)
        timeline.on(DockQueued, lambda _at, event: self._queue(event.robot, queues=True))
        timeline.on(Docked, lambda _at, event: self._queue(event.robot, queues=False))
        timeline.on((BatteryEmpty, BatteryRevived, ChargingBegan, ChargingEnded, FaultBegan, FaultEnded), self._apply)
        timeline.on(Teleported, lambda _at, event: self._stand(event.entity, waits=False))
        timeline.on(Spawned, self._spawn)
        timeline.on(Deleted, self._delete)
        timeline.on(SceneSeen, self._see)

    def is_(self, name: str, state: str) -> bool:
        """Return whether a robot is present and in a state."""
        robot = self._robots.get(name)
        return robot is not None and robot.present and robot.state == state

    def state_of(self, name: str) -> State:
        """Return the state of a robot that exists or has existed."""
        return self._robots[name].state

    def begin_anew(self) -> None:
        """Return to the robots of the world, all idle."""
        for name, robot in self._robots.items():
            self._halt(robot)
            robot.condition.clear()
            robot.running.clear()
            robot.waits = robot.queues = robot.aside = False
            self._settle(name, robot, present=name in self._world.robots)

    def _halt(self, robot: Robot) -> None:
        if robot.arrives is not None:
            robot.arrives.cancel()
            robot.arrives = None

    def _stand(self, name: str, *, waits: bool) -> None:
        robot = self._robots.get(name)
        if robot is not None:
            self._halt(robot)
            robot.waits = waits
            self._settle(name, robot)

    def _go_on(self, _at: int, event: WentOn | Rerouted | MadeRoom) -> None:
        robot = self._robots.get(event.robot)
        if robot is not None:
            robot.waits, robot.aside = False, isinstance(event, MadeRoom) and not robot.queues
            self._settle(event.robot, robot)

    def _queue(self, name: str, *, queues: bool) -> None:
        robot = self._robots.get(name)
        if robot is not None:
            robot.queues = queues

    def _move(self, at: int, event: MotionBegan) -> None:
        robot = self._robots.get(event.robot)
        if robot is not None:
            self._halt(robot)
            robot.waits = False
            self._go(event.robot, robot, at + _duration(event))
            self._settle(event.robot, robot)

    def _go(self, name: str, robot: Robot, until: int) -> None:
        if until <= self._timeline.now:
            # A turn by no angle, as at the end of some routes.
            return

        def arrive(_at: int) -> None:
            robot.arrives = None
            self._settle(name, robot)

        robot.arrives = self._timeline.alarm(until, Phase.CHANGE, arrive)

    def _goal(self, _at: int, goal: GoalSeen) -> None:
        robot = self._robots.get(goal.robot)
        if robot is not None:
            _set(robot.running, goal.goal_id, applies=goal.status < GoalStatus.SUCCEEDED)
            if goal.status >= GoalStatus.SUCCEEDED:
                robot.queues = robot.aside = False
            self._settle(goal.robot, robot)

    def _apply(self, _at: int, event: FaultBegan | FaultEnded | BatteryEvent) -> None:
        robot = self._robots.get(event.robot)
        if robot is not None:
            robot.condition.apply(event)
            self._settle(event.robot, robot)

    def _spawn(self, _at: int, event: Spawned) -> None:
        if event.type != "item":
            self._settle(event.entity, self._robots.setdefault(event.entity, Robot(present=False)), present=True)

    def _delete(self, _at: int, event: Deleted) -> None:
        robot = self._robots.get(event.entity)
        if robot is not None:
            self._settle(event.entity, robot, present=False)

    def _see(self, at: int, scene: SceneSeen) -> None:
        self.begin_anew()
        seen = {text(robot, "name"): robot for robot in records(scene.fields, "robots")}
        for name in [*self._robots, *seen]:
            robot = self._robots.setdefault(name, Robot(present=False))
            if name in seen:
                self._see_robot(at, name, robot, seen[name])
            self._settle(name, robot, present=name in seen)
        for fault in records(scene.fields, "faults"):
            self._apply(at, FaultBegan.from_json(fault))

    def _see_robot(self, at: int, name: str, robot: Robot, seen: Mapping[str, Any]) -> None:
        robot.condition.see(seen)
        robot.waits = bool(seen.get("waits"))
        for goal in records(seen, "goals"):
            if whole(goal, "status") < GoalStatus.SUCCEEDED:
                robot.running[text(goal, "goal_id")] = None
        moving = motion_in(seen, at, self._timeline.offset)
        if moving is not None:
            began, event = moving
            self._go(name, robot, began + _duration(event))

    def _settle(self, name: str, robot: Robot, *, present: bool | None = None) -> None:
        """Work out the state of a robot."""
        before = robot.present, robot.state
        if present is not None:
            robot.present = present
        robot.state = robot.condition.state(
            waits=robot.waits, aside=robot.aside, moves=robot.arrives is not None, busy=bool(robot.running)
        )
        if (robot.present, robot.state) != before:
            self.changed(name)


def _duration(event: MotionBegan) -> int:
    """Return the duration of a motion with all its further segments, in nanoseconds."""
    seconds = event.duration + math.fsum(number(each, "duration") for each in event.then)
    return round(min(max(seconds, 0.0), _MAX_SECONDS) * NANOSECONDS)


class Batteries(Part):
    """The charge of batteries as a share of their capacity, watched by robot.

    It is known when a battery is read: with its events, and in a running simulation at each instant with an event; in
    a recording about once a second.

    Attributes:
        shares: The remaining share of each battery that is followed, by robot.
    """

    def __init__(self, timeline: Timeline, world: World) -> None:
        super().__init__()
        self._world = world
        self.shares: dict[str, float] = {}
        timeline.on((*BATTERIES.events, BatterySeen), self._read)
        timeline.on(SceneSeen, self._see)

    def follow(self, robot: str) -> None:
        """Follow the battery of a robot from now on; the share is 1 without a battery."""
        if robot not in self.shares:
            self.shares[robot] = self._initial(robot)

    def begin_anew(self) -> None:
        """Return all batteries to their initial charge."""
        for robot in self.shares:
            self._read(0, BatterySeen(robot, self._initial(robot)))

    def _initial(self, robot: str) -> float:
        spec = self._world.robots.get(robot)
        settings = self._world.robot_type(spec).components.get("battery") if spec else None
        if settings is None:
            return 1.0
        battery = BatterySettings.model_validate(settings)
        return 1.0 if battery.initial_charge is None else battery.initial_charge / battery.capacity

    def _read(self, _at: int, battery: BatteryEvent | BatterySeen) -> None:
        robot, share = battery.robot, battery.percentage
        if self.shares.get(robot, share) != share:
            self.shares[robot] = share
            self.changed(robot)

    def _see(self, at: int, scene: SceneSeen) -> None:
        for robot in records(scene.fields, "robots"):
            battery = robot.get("battery")
            if isinstance(battery, dict):
                self._read(at, BatterySeen(text(robot, "name"), number(battery, "percentage")))
