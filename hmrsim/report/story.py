"""The story of a run, built from its occurrences in order."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from typing import Any

from hmrsim.events.faults import FaultBegan, FaultEnded
from hmrsim.events.goals import GoalAccepted, GoalStatusChanged, SendGoalRejected
from hmrsim.events.robots import BATTERIES, BatteryEvent, MotionBegan, Stopped
from hmrsim.events.simulation import SimulationReset, WorldLoaded
from hmrsim.events.traffic import WentOn
from hmrsim.history.facilities import Docks, Doors, Lanes, Lifts
from hmrsim.history.history import Faults
from hmrsim.history.items import Orders
from hmrsim.history.motion import Motion, motion_in
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
from hmrsim.history.timeline import Timeline
from hmrsim.protocol.goal import GoalStatus
from hmrsim.report.delays import Delays
from hmrsim.report.goals import GoalLog, WaitRecord
from hmrsim.report.robots import RobotLog, Waiting


class Story:
    """Processes occurrences in order of time, and collects the content of a report.

    Time continues after a reset, so all times are nanoseconds since the run began.
    """

    def __init__(self) -> None:
        self.timeline = timeline = Timeline()
        self.faults, self.orders = Faults(timeline), Orders(timeline)
        self.doors, self.lanes = Doors(timeline), Lanes(timeline)
        self.lifts, self.docks = Lifts(timeline), Docks(timeline)
        self.robot_log = robot_log = RobotLog(timeline)
        self.goal_log = GoalLog()
        self.waiting = Waiting(timeline, robot_log, self.lanes)
        self.delays = Delays(timeline, robot_log)
        self.counts = Counter[str]()
        self.misfits = 0
        self.first_misfit = ""
        self._anew = True
        self._over = False
        takers: dict[type, Callable[[int, Any], object]] = {
            SceneSeen: self._scene,
            MotionBegan: self._motion,
            Stopped: self._stopped,
            GoalAccepted: self.goal_log.ask_of,
            Commanded: self.goal_log.command,
            GoalStatusChanged: self._status,
            SendGoalRejected: self._rejected,
            BatterySeen: self._battery,
            **dict.fromkeys(BATTERIES.events, self._on_battery),
            FaultBegan: self._fault,
            FaultEnded: self._fault,
            SimulationReset: self._begun_anew,
            WorldLoaded: self._begun_anew,
            Malformed: self._left_out,
        }
        for kind, taker in takers.items():
            timeline.on(kind, taker)

    def take(self, occurrence: Occurrence) -> None:
        """Process an occurrence; an invalid one is ignored, and counted, and one after the end is ignored.

        The last ones come when Python frees the processes of a simulation that is over, which stop their robots.
        """
        if self._over:
            return
        event, counted = occurrence.event, occurrence.counted
        if self.timeline.began is None:
            self.timeline.begin(occurrence.at)
        if counted:
            self.counts[counted] += 1
        try:
            if isinstance(event, SceneSeen) and not self._anew:
                self.timeline.give(occurrence.at, event, (self._added_in,))
            else:
                self.timeline.take(occurrence)
        except ValueError as error:
            self._left_out(occurrence.at, Malformed(counted or type(event).__name__, str(error)))

    def end(self, at: int | None = None) -> None:
        """Record the end of the run, at some time or that of the last occurrence."""
        self.timeline.end(at)
        self.robot_log.keep(set(), self.now)
        for facilities in (self.doors, self.lanes, self.lifts, self.docks):
            facilities.end(self.now)
        self._over = True

    @property
    def now(self) -> int:
        """The time of the last occurrence, or of the end of the run."""
        return self.timeline.now

    @property
    def began(self) -> int | None:
        """The time of the first occurrence."""
        return self.timeline.began

    @property
    def seen(self) -> bool:
        """True if the initial state is known."""
        return not self._anew

    @property
    def metered(self) -> bool:
        """True if the charge of any battery is known."""
        return any(track.charge is not None for track in self.robot_log.tracks.values())

    def _left_out(self, _at: int, event: Malformed) -> None:
        self.misfits += 1
        self.first_misfit = self.first_misfit or f"{event.kind}: {event.error}"

    def _scene(self, at: int, scene: SceneSeen) -> None:
        """Start from the first scene of the run, or after a reset."""
        robots = records(scene.fields, "robots")
        self.robot_log.keep({text(robot, "name") for robot in robots}, at)
        for robot in robots:
            self._see(robot, at, added=False)
        for fault in records(scene.fields, "faults"):
            self._fault(at, FaultBegan.from_json(fault))
        self._anew = False

    def _added_in(self, at: int, scene: SceneSeen) -> None:
        """Record the robots of a later scene whose addition is missing."""
        for robot in records(scene.fields, "robots"):
            known = self.robot_log.tracks.get(text(robot, "name"))
            if known is None or known.ended is not None:
                self._see(robot, at, added=True)

    def _see(self, robot: Mapping[str, Any], at: int, *, added: bool) -> None:
        """Start from the state of a robot in a scene."""
        track = self.robot_log.track(text(robot, "name"), at, text(robot, "type", "") if added else "")
        track.type = text(robot, "type", "")
        track.condition.see(robot)
        battery = robot.get("battery")
        if isinstance(battery, dict):
            track.measure(at, number(battery, "percentage"))
        for goal in records(robot, "goals"):
            if not GoalStatus(whole(goal, "status")).terminal:
                self.goal_log.ask_of(at, GoalAccepted.from_json(goal))
                self._status(at, GoalStatusChanged.from_json(goal))
        moving = motion_in(robot, at, self.timeline.offset)
        motions = Motion.all_of(*moving) if moving else []
        # Events may have said already that it drives, or waits.
        if not motions or not track.drives(motions[0]):
            track.halt(at)
            if motions:
                track.drive(motions)
        if not motions and robot.get("waits") and track.wait is None:
            track.wait = WaitRecord(track.name, at, "way", goal=track.goal)
        track.settle(at)

    def _motion(self, at: int, event: MotionBegan) -> None:
        track = self.robot_log.track(event.robot, at)
        track.stop_waiting(at, WentOn.kind)
        track.stop_queueing(at, WentOn.kind)
        track.drive(Motion.all_of(at, event))
        track.settle(at)

    def _stopped(self, at: int, event: Stopped) -> None:
        track = self.robot_log.track(event.robot, at)
        track.stop_waiting(at, event.kind)
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
            goal.faults = self.faults.of(goal.robot)
            if track.aside is not None:
                track.aside = None
                track.stop_waiting(at, "end")
            if track.queued is not None and track.queued.goal is goal:
                track.stop_queueing(at, "end")
        track.settle(at)

    def _rejected(self, at: int, event: SendGoalRejected) -> None:
        self.goal_log.rejected.append((at, event, self.faults.of(event.robot)))

    def _battery(self, at: int, battery: BatterySeen) -> None:
        track = self.robot_log.track(battery.robot, at)
        if battery.charge is None:
            track.measure(at, battery.percentage)
        else:
            track.weigh(at, battery.charge, battery.percentage)

    def _on_battery(self, at: int, event: BatteryEvent) -> None:
        track = self.robot_log.track(event.robot, at)
        track.measure(at, event.percentage)
        track.condition.apply(event)
        track.settle(at)

    def _fault(self, at: int, event: FaultBegan | FaultEnded) -> None:
        if event.robot in self.robot_log.tracks:
            track = self.robot_log.track(event.robot, at)
            track.condition.apply(event)
            track.settle(at)

    def _begun_anew(self, at: int, event: SimulationReset | WorldLoaded) -> None:
        self._anew = True
        self.faults.begin_anew()
        self.orders.begin_anew()
        self.robot_log.reset(at, event)
