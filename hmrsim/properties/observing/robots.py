"""The states of robots, in the words of reports."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

from hmrsim.events.faults import FaultBegan, FaultEnded
from hmrsim.events.robots import BatteryEmpty, BatteryRevived, ChargingBegan, ChargingEnded, MotionBegan, Stopped
from hmrsim.events.simulation import Deleted, Spawned, Teleported
from hmrsim.events.traffic import MadeRoom, Rerouted, Waiting, WentOn
from hmrsim.history.occurrence import SceneSeen, number, records, text, whole
from hmrsim.history.timeline import GoalSeen, Phase
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.properties.observing.signal import Signal
from hmrsim.protocol.goal import GoalStatus
from hmrsim.report.track import state_of

if TYPE_CHECKING:
    from hmrsim.history.timeline import Alarm, Timeline
    from hmrsim.world.model import World

_TERMINAL: Final = int(GoalStatus.SUCCEEDED)
_EMPTY: Final = "battery_empty"
_MAX_SECONDS: Final = 1e9
_AILMENTS: Final = {"breakdown": "disabled", "messages_lost": "cut_off"}
"""The faults by which a robot is in another state, and the field that says so."""


@dataclass(slots=True)
class _Robot:
    """What is known of a robot."""

    there: bool = True
    disabled: dict[str, None] = field(default_factory=dict)
    cut_off: dict[str, None] = field(default_factory=dict)
    waits: bool = False
    charging: bool = False
    running: dict[str, None] = field(default_factory=dict)
    arrives: Alarm | None = None
    state: str = "idle"
    signals: dict[str, Signal] = field(default_factory=dict)


class Robots:
    """Follows what the robots of a world do."""

    def __init__(self, world: World, timeline: Timeline) -> None:
        self._world, self._timeline = world, timeline
        self._robots = {name: _Robot() for name in world.robots}
        timeline.on(GoalSeen, self._goal)
        timeline.on(MotionBegan, self._move)
        timeline.on(Stopped, lambda _at, event: self._stand(event.robot, waits=False))
        timeline.on(Waiting, lambda _at, event: self._stand(event.robot, waits=True))
        for goes_on in (WentOn, Rerouted, MadeRoom):
            timeline.on(goes_on, lambda _at, event: self._change(event.robot, waits=False))
        for charging in (ChargingBegan, ChargingEnded):
            timeline.on(charging, self._charge)
        timeline.on(BatteryEmpty, lambda _at, event: self._hit(event.robot, "disabled", _EMPTY, begins=True))
        timeline.on(BatteryRevived, lambda _at, event: self._hit(event.robot, "disabled", _EMPTY, begins=False))
        for fault in (FaultBegan, FaultEnded):
            timeline.on(fault, self._fault)
        timeline.on(Teleported, lambda _at, event: self._stand(event.entity, waits=False))
        timeline.on(Spawned, self._spawn)
        timeline.on(Deleted, lambda _at, event: self._change(event.entity, there=False))
        timeline.on(SceneSeen, self._see)

    def is_(self, robot: str, state: str) -> Signal:
        """Return whether a robot is in a state."""
        known = self._robots.get(robot)
        if known is None:
            known = self._robots[robot] = _Robot(there=False)
        if state not in known.signals:
            known.signals[state] = Signal()
            known.signals[state].say(holds=known.there and known.state == state)
        return known.signals[state]

    def begin_anew(self) -> None:
        """Let all robots do nothing."""
        for name, robot in self._robots.items():
            self._cease(robot)
            robot.there, robot.waits, robot.charging = name in self._world.robots, False, False
            robot.disabled.clear()
            robot.cut_off.clear()
            robot.running.clear()
            self._settle(robot)

    def _change(self, name: str, **fields: bool) -> None:
        robot = self._robots.get(name)
        if robot is not None:
            for key, value in fields.items():
                setattr(robot, key, value)
            self._settle(robot)

    def _cease(self, robot: _Robot) -> None:
        if robot.arrives is not None:
            robot.arrives.cancel()
            robot.arrives = None

    def _stand(self, name: str, *, waits: bool) -> None:
        robot = self._robots.get(name)
        if robot is not None:
            self._cease(robot)
            robot.waits = waits
            self._settle(robot)

    def _move(self, at: int, event: MotionBegan) -> None:
        robot = self._robots.get(event.robot)
        if robot is None:
            return
        self._cease(robot)
        robot.waits = False
        self._go(robot, at + _length(event))

    def _go(self, robot: _Robot, until: int) -> None:
        def arrive(_at: int) -> None:
            robot.arrives = None
            self._settle(robot)

        robot.arrives = self._timeline.alarm(until, Phase.CHANGE, arrive)
        self._settle(robot)

    def _goal(self, _at: int, goal: GoalSeen) -> None:
        robot = self._robots.get(goal.robot)
        if robot is not None:
            if goal.status < _TERMINAL:
                robot.running[goal.goal_id] = None
            else:
                robot.running.pop(goal.goal_id, None)
            self._settle(robot)

    def _charge(self, _at: int, event: ChargingBegan | ChargingEnded) -> None:
        self._change(event.robot, charging=isinstance(event, ChargingBegan))

    def _fault(self, _at: int, event: FaultBegan | FaultEnded) -> None:
        if event.fault in _AILMENTS:
            self._hit(event.robot, _AILMENTS[event.fault], event.name, begins=isinstance(event, FaultBegan))

    def _hit(self, name: str, kind: str, cause: str, *, begins: bool) -> None:
        robot = self._robots.get(name)
        if robot is not None:
            causes: dict[str, None] = getattr(robot, kind)
            if begins:
                causes[cause] = None
            else:
                causes.pop(cause, None)
            self._settle(robot)

    def _spawn(self, _at: int, event: Spawned) -> None:
        if event.type != "item":
            self._robots.setdefault(event.entity, _Robot()).there = True
            self._settle(self._robots[event.entity])

    def _see(self, at: int, scene: SceneSeen) -> None:
        self.begin_anew()
        said = {text(robot, "name"): robot for robot in records(scene.fields, "robots")}
        for name in [*self._robots, *said]:
            robot = self._robots.setdefault(name, _Robot())
            robot.there = name in said
            if robot.there:
                self._see_robot(at, robot, said[name])
            self._settle(robot)
        for fault in records(scene.fields, "faults"):
            self._fault(at, FaultBegan.from_json(fault))

    def _see_robot(self, at: int, robot: _Robot, said: Mapping[str, Any]) -> None:
        ailments, battery, motion = said.get("ailments"), said.get("battery"), said.get("motion")
        if isinstance(ailments, dict) and _EMPTY in ailments:
            robot.disabled[_EMPTY] = None
        robot.charging = isinstance(battery, dict) and bool(battery.get("charging"))
        robot.waits = bool(said.get("waits"))
        for goal in records(said, "goals"):
            if whole(goal, "status") < _TERMINAL:
                robot.running[text(goal, "goal_id")] = None
        if isinstance(motion, dict):
            event = MotionBegan.from_json({**motion, "robot": ""})
            since = motion.get("began")
            began = round(number(motion, "began") * NANOSECONDS) if since is not None else at
            self._go(robot, min(began, at) + _length(event))

    def _settle(self, robot: _Robot) -> None:
        state = state_of(
            cut_off=bool(robot.cut_off),
            disabled=bool(robot.disabled),
            waits=robot.waits,
            moves=robot.arrives is not None,
            charging=robot.charging,
            busy=bool(robot.running),
        )
        robot.state = state
        for name, signal in robot.signals.items():
            signal.say(holds=robot.there and name == state)


def _length(event: MotionBegan) -> int:
    """Return how long a motion takes, with all that follows, in nanoseconds."""
    seconds = event.duration + math.fsum(number(each, "duration") for each in event.then)
    return round(min(max(seconds, 0.0), _MAX_SECONDS) * NANOSECONDS)
