"""The story of a run, built from its occurrences in order."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

from hmrsim.engine.sim_time import JITTER
from hmrsim.events import traffic as events
from hmrsim.events.faults import FaultBegan, FaultEnded
from hmrsim.events.goals import GoalAccepted, GoalStatusChanged, SendGoalRejected
from hmrsim.events.robots import (
    BATTERIES,
    BatteryEmpty,
    BatteryEvent,
    BatteryRevived,
    ChargingBegan,
    ChargingEnded,
    Docked,
    DockQueued,
    MotionBegan,
    Stopped,
)
from hmrsim.events.simulation import Deleted, SimulationReset, Spawned, Teleported, WorldLoaded
from hmrsim.events.traffic import Deadlock, MadeRoom, Rerouted, WentOn
from hmrsim.history.motion import Motion
from hmrsim.history.occurrence import (
    BatterySeen,
    Commanded,
    Malformed,
    Occurrence,
    SceneSeen,
    number,
    records,
    text,
    whole,
)
from hmrsim.protocol.goal import GoalStatus
from hmrsim.report.facility_log import FacilityLog
from hmrsim.report.goals import GoalLog, WaitRecord
from hmrsim.report.order_log import OrderLog
from hmrsim.report.robots import FaultLog, FaultRecord, RobotLog, Waiting, hit

if TYPE_CHECKING:
    from hmrsim.report.track import Track

_SAMPLED: Final = (SceneSeen, BatterySeen)
"""Occurrences that may arrive late, so that they do not indicate a reset of time."""

_EMPTY: Final = BatteryEmpty.kind
"""Why a robot with an empty battery is disabled."""


@dataclass
class Story:
    """Processes occurrences in order of time, and collects the content of a report.

    Time continues after a reset, so all times are nanoseconds since the run began.
    """

    robot_log: RobotLog = field(default_factory=RobotLog)
    goal_log: GoalLog = field(default_factory=GoalLog)
    facility_log: FacilityLog = field(default_factory=FacilityLog)
    fault_log: FaultLog = field(default_factory=FaultLog)
    order_log: OrderLog = field(default_factory=OrderLog)
    counts: Counter[str] = field(default_factory=Counter)
    misfits: int = 0
    first_misfit: str = ""
    now: int = 0
    restarts: int = 0
    _offset: int = 0
    _anew: bool = True
    _over: bool = False

    def __post_init__(self) -> None:
        """Map each kind of occurrence to its handler."""
        robot_log, self.waiting = self.robot_log, Waiting(self.robot_log)
        self._takers: dict[type, Callable[[int, Any], object]] = {
            SceneSeen: self._scene,
            MotionBegan: self._motion,
            Stopped: self._stopped,
            Teleported: robot_log.teleported,
            GoalAccepted: self.goal_log.ask_of,
            Commanded: self.goal_log.command,
            GoalStatusChanged: self._status,
            SendGoalRejected: self._rejected,
            events.Waiting: self.waiting.begin,
            **dict.fromkeys((WentOn, Rerouted, MadeRoom), self.waiting.end),
            DockQueued: self.waiting.queue,
            Docked: self.waiting.dock,
            Deadlock: self.waiting.lock,
            BatterySeen: self._battery,
            **dict.fromkeys(BATTERIES.events, self._on_battery),
            FaultBegan: self._fault_began,
            FaultEnded: self._fault_ended,
            Spawned: robot_log.spawned,
            Deleted: robot_log.deleted,
            SimulationReset: self._begun_anew,
            WorldLoaded: self._begun_anew,
            Malformed: self._left_out,
        }

    def take(self, occurrence: Occurrence) -> None:
        """Process an occurrence; an invalid one is ignored, and counted, and one after the end is ignored.

        The last ones come when Python frees the processes of a simulation that is over, which stop their robots.
        """
        if self._over:
            return
        try:
            self._take(occurrence)
        except ValueError as error:
            self._left_out(occurrence.at, Malformed(occurrence.counted or type(occurrence.event).__name__, str(error)))

    def end(self, at: int | None = None) -> None:
        """Record the end of the run, at some time or that of the last occurrence."""
        if at is not None and at + self._offset > self.now:
            self.now = at + self._offset
        self.robot_log.keep(set(), self.now)
        self.facility_log.end(self.now)
        self._over = True

    @property
    def began(self) -> int | None:
        """The time of the first occurrence."""
        return self.robot_log.began

    @property
    def seen(self) -> bool:
        """Whether the initial state is known."""
        return not self._anew

    @property
    def metered(self) -> bool:
        """Whether the charge of any battery is known."""
        return any(track.charge is not None for track in self.robot_log.tracks.values())

    def _take(self, occurrence: Occurrence) -> None:
        # A stamp of one nanosecond is that of time 0, which ROS reads as unset.
        at = (0 if occurrence.at == 1 else occurrence.at) + self._offset
        if self.robot_log.began is None:
            self.robot_log.began = self.now = at
        event = occurrence.event
        if isinstance(event, _SAMPLED) or at >= self.now - JITTER:
            at = max(at, self.now)
        else:
            self._offset += self.now - at
            self.restarts += 1
            at = self.now
        self.now = at
        if occurrence.counted:
            self.counts[occurrence.counted] += 1
        taker = self._takers.get(type(event))
        if taker is not None:
            taker(at, event)
        self.facility_log.take(at, event)
        self.order_log.take(at, event)

    def _left_out(self, _at: int, event: Malformed) -> None:
        self.misfits += 1
        self.first_misfit = self.first_misfit or f"{event.kind}: {event.error}"

    def _scene(self, at: int, scene: SceneSeen) -> None:
        said = records(scene.fields, "robots")
        names = {text(robot, "name") for robot in said}
        if self._anew:
            self.robot_log.keep(names, at)
        for robot in said:
            known = self.robot_log.tracks.get(text(robot, "name"))
            if self._anew or known is None or known.ended is not None:
                self._see(robot, at, gone=not self._anew)
        if self._anew:
            for fault in records(scene.fields, "faults"):
                self._hit(self.fault_log.begin(at, FaultBegan.from_json(fault)), at, begins=True)
            self.facility_log.see(at, scene.fields)
        self._anew = False

    def _see(self, robot: Mapping[str, Any], at: int, *, gone: bool) -> None:
        """Start from the state of a robot in a scene."""
        track = self.robot_log.track(text(robot, "name"), at, text(robot, "type", "") if gone else "")
        track.type = text(robot, "type", "")
        # Other reasons are faults, which the scene lists separately.
        ailments, battery = robot.get("ailments"), robot.get("battery")
        track.disabled_reasons = {_EMPTY} if isinstance(ailments, dict) and _EMPTY in ailments else set()
        if isinstance(battery, dict):
            track.measure(at, number(battery, "percentage"))
            track.charging = bool(battery.get("charging"))
        for goal in records(robot, "goals"):
            if not GoalStatus(whole(goal, "status")).terminal:
                self.goal_log.ask_of(at, GoalAccepted.from_json(goal))
                self._status(at, GoalStatusChanged.from_json(goal))
        motions = self._motions_in(robot, at, track)
        # Events may have said already that it drives, or waits.
        if not motions or not track.drives(motions[0]):
            track.halt(at)
            if motions:
                track.drive(motions)
        if not motions and robot.get("waits") and track.wait is None:
            track.wait = WaitRecord(track.name, at, "way", goal=track.goal)
        track.settle(at)

    def _motions_in(self, robot: Mapping[str, Any], at: int, track: Track) -> list[Motion]:
        """Return how a robot moves in a scene, and is going to."""
        motion = robot.get("motion")
        if not isinstance(motion, dict):
            return []
        began = motion.get("began")
        since = round(number(motion, "began") * 1e9) + self._offset if began is not None else at
        return Motion.all_of(min(since, at), MotionBegan.from_json({**motion, "robot": track.name}))

    def _motion(self, at: int, event: MotionBegan) -> None:
        track = self.robot_log.track(event.robot, at)
        track.stand_no_more(at, WentOn.kind)
        track.stop_queueing(at, WentOn.kind)
        track.drive(Motion.all_of(at, event))
        track.settle(at)

    def _stopped(self, at: int, event: Stopped) -> None:
        track = self.robot_log.track(event.robot, at)
        track.stand_no_more(at, event.kind)
        track.halt(at, event.at)
        track.settle(at)

    def _status(self, at: int, event: GoalStatusChanged) -> None:
        goal = self.goal_log.change(at, event)
        track = self.robot_log.track(goal.robot, at)
        if goal.ended is None:
            track.running[goal.goal_id] = goal
        else:
            track.running.pop(goal.goal_id, None)
            goal.waiting = track.waiting_for(goal, at)
            goal.faults = self.fault_log.at(goal.robot)
            if track.queued is not None and track.queued.goal is goal:
                track.stop_queueing(at, "end")
        track.settle(at)

    def _rejected(self, at: int, event: SendGoalRejected) -> None:
        self.goal_log.rejected.append((at, event, self.fault_log.at(event.robot)))

    def _battery(self, at: int, battery: BatterySeen) -> None:
        track = self.robot_log.track(battery.robot, at)
        if battery.charge is None:
            track.measure(at, battery.percentage)
        else:
            track.weigh(at, battery.charge, battery.percentage)

    def _on_battery(self, at: int, event: BatteryEvent) -> None:
        track = self.robot_log.track(event.robot, at)
        track.measure(at, event.percentage)
        match event:
            case BatteryEmpty():
                track.disabled_reasons.add(_EMPTY)
            case BatteryRevived():
                track.disabled_reasons.discard(_EMPTY)
            case ChargingBegan() | ChargingEnded():
                track.charging = isinstance(event, ChargingBegan)
        track.settle(at)

    def _fault_began(self, at: int, event: FaultBegan) -> None:
        self._hit(self.fault_log.begin(at, event), at, begins=True)

    def _fault_ended(self, at: int, event: FaultEnded) -> None:
        self._hit(self.fault_log.end(at, event.name), at, begins=False)

    def _hit(self, fault: FaultRecord | None, at: int, *, begins: bool) -> None:
        if fault is not None and fault.robot in self.robot_log.tracks:
            track = self.robot_log.track(fault.robot, at)
            hit(fault, track, begins=begins)
            track.settle(at)

    def _begun_anew(self, at: int, event: SimulationReset | WorldLoaded) -> None:
        self._anew = True
        self.fault_log.going_on.clear()
        self.order_log.begin_anew()
        self.robot_log.reset(at, event)
