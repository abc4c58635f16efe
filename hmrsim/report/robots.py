"""The robots of a run for a report: the states, distance, battery and waits of each."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from hmrsim.events import traffic as events
from hmrsim.events.robots import Docked, DockQueued
from hmrsim.events.simulation import Deleted, Spawned, Teleported
from hmrsim.geometry import distance
from hmrsim.history.motion import INSTANT
from hmrsim.history.robots import Condition
from hmrsim.report.goals import WaitRecord

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hmrsim.events.simulation import SimulationReset, WorldLoaded
    from hmrsim.geometry import Point
    from hmrsim.history.facilities import Lanes
    from hmrsim.history.motion import Motion
    from hmrsim.history.robots import State
    from hmrsim.history.timeline import Timeline
    from hmrsim.report.goals import GoalRecord


@dataclass(slots=True)
class LaneUse:
    """The use of a lane in one direction; times in nanoseconds."""

    drives: int = 0
    distance: float = 0.0
    time: int = 0


@dataclass(slots=True)
class Track:
    """The record of one robot.

    The caller changes the attributes; `settle` then records the resulting state.

    Attributes:
        began: When the robot was added; times are in nanoseconds.
        ended: When it was removed; None while it is present.
        used: The energy that it has used, in the unit of its battery.
        curve: The charge of its battery over time, as shares of the capacity.
        spans: Its past states, each with its beginning and end.
        motion: The segment that it drives now; None while it stands.
        coming: The segments that follow the current one without a further event.
        wait: Its current wait on its way; None if it does not wait.
        queued: Its current place in the queue of a dock; None if it is in none.
        aside: The reason for which the robot waits after it made room during its goal; None if it has not made room.
    """

    name: str
    type: str
    began: int
    ended: int | None = None
    distance: float = 0.0
    charge: float | None = None
    used: float = 0.0
    charged: float = 0.0
    curve: list[tuple[int, float]] = field(default_factory=list)
    spans: list[tuple[int, int, State]] = field(default_factory=list)
    motion: Motion | None = None
    coming: Sequence[Motion] = ()
    wait: WaitRecord | None = None
    queued: WaitRecord | None = None
    aside: WaitRecord | None = None
    stood: list[WaitRecord] = field(default_factory=list)
    condition: Condition = field(default_factory=Condition)
    running: dict[str, GoalRecord] = field(default_factory=dict)
    lanes: dict[tuple[str, str] | None, LaneUse] = field(default_factory=lambda: defaultdict(LaneUse))
    paths: dict[tuple[Point, Point], int] = field(default_factory=lambda: defaultdict(int))
    _state: State = "idle"
    _since: int = 0
    _last: Motion | None = None
    _pursued: GoalRecord | None = None

    def __post_init__(self) -> None:
        """Begin the first state when the robot is added."""
        self._since = self.began

    @property
    def goal(self) -> GoalRecord | None:
        """The running goal that holds the robot's base, or else the first one that runs."""
        chosen = None
        for goal in self.running.values():
            if goal.holds_base or chosen is None:
                chosen = goal
        return chosen

    def waiting_for(self, goal: GoalRecord, at: int) -> WaitRecord | None:
        """Return the wait during a goal that goes on, or that has ended at this instant."""
        for wait in (self.wait, self.queued, *self.stood[-1:]):
            if wait is not None and wait.goal is goal and wait.ended in (None, at):
                return wait
        return None

    def stop_waiting(self, at: int, until: str) -> None:
        """Record the end of the robot's wait on its way, if it waited."""
        wait, self.wait = self.wait, None
        self._keep(wait, at, until)

    def stop_queueing(self, at: int, until: str) -> None:
        """Record that the robot has left the queue of a dock, if it was in one."""
        queued, self.queued = self.queued, None
        self._keep(queued, at, until)

    def _keep(self, wait: WaitRecord | None, at: int, until: str) -> None:
        """Keep a wait that has ended, unless it had no duration."""
        if wait is None or wait.began == at:
            return
        wait.ended, wait.until = at, until
        continues_last = any(part.since == wait.since and part.kind == wait.kind for part in self.stood[-1:])
        self.stood.append(wait)
        if wait.goal is not None:
            wait.goal.waits += not continues_last
            wait.goal.waited += at - wait.began

    def return_at(self, at: int) -> None:
        """Record that a robot of this name was added again."""
        self.ended, self._since, self._state = None, at, "idle"

    def catch_up(self, at: int) -> None:
        """End the segments and states that have ended by a time without an event."""
        while (motion := self.motion) is not None and motion.until <= at + INSTANT:
            if self.coming:
                if motion.until >= at - INSTANT:
                    # The robot may stop here; then the next segment never begins.
                    return
                self._go(*self.coming)
                continue
            ended = at if motion.until >= at - INSTANT else motion.until
            self.halt(ended, motion.end)
            if self.aside is not None and self.running:
                self.stand_aside(ended, motion.end, self.aside)
            self.settle(ended)

    def stand_aside(self, at: int, where: Point, wait: WaitRecord) -> None:
        """Record that the robot waits at the place to which it has moved to make room."""
        if wait.kind == "dock":
            self.queued = replace(wait, began=at, ended=None, until="")
        else:
            self.wait = replace(wait, began=at, at=where, since=at)

    def halt(self, at: int, where: Point | None = None) -> None:
        """End the current segment, at the point *where* if that is known."""
        motion, self.coming = self.motion, ()
        if motion is None:
            return
        self.motion = None
        straight = motion.length > 0
        driven = min(motion.length, distance(motion.start, where)) if where and straight else motion.driven(at)
        self.distance += driven
        if self._pursued is not None:
            self._pursued.distance += driven
        if straight:
            use = self.lanes[motion.lane]
            use.distance += driven
            use.time += at - motion.began

    def drives(self, motion: Motion) -> bool:
        """Return whether the robot already drives a segment with this beginning and end."""
        known = self.motion
        return known is not None and known.end == motion.end and abs(known.began - motion.began) <= INSTANT

    def drive(self, motions: Sequence[Motion]) -> None:
        """Begin the segments of a motion for the robot's goal, and end the current segment where they begin."""
        self.halt(motions[0].began, motions[0].start)
        self._pursued = self.goal
        self._go(*motions)

    def _go(self, motion: Motion, *coming: Motion) -> None:
        """Begin a segment, which others follow, and end the current segment where it begins."""
        self.halt(motion.began, motion.start)
        self.motion, self.coming = motion, coming
        if motion.length <= 0:
            return
        # A robot that continues at another speed is still on the same drive.
        last, self._last = self._last, motion
        if last is not None and (last.lane, last.end) == (motion.lane, motion.end) and last.start != motion.start:
            return
        self.lanes[motion.lane].drives += 1
        if motion.lane is None:
            a, b = sorted((round(x, 2), round(y, 2)) for x, y in (motion.start, motion.end))
            self.paths[a, b] += 1

    def settle(self, at: int) -> None:
        """Record the robot's state from now on, as the attributes imply it."""
        state = self.condition.state(
            waits=self.wait is not None, aside=False, moves=self.motion is not None, busy=bool(self.running)
        )
        if state == self._state:
            return
        self._close(at)
        self._state, self._since = state, at

    def leave(self, at: int) -> None:
        """Record that the robot was removed, or that the run has ended."""
        self.catch_up(at)
        self.halt(at)
        self._close(at)
        self._since = at
        self.ended = at

    def _close(self, at: int) -> None:
        if at <= self._since:
            return
        if self.spans and self.spans[-1][2] == self._state and self.spans[-1][1] == self._since:
            self.spans[-1] = (self.spans[-1][0], at, self._state)
        else:
            self.spans.append((self._since, at, self._state))

    def weigh(self, at: int, charge: float, share: float) -> None:
        """Record the charge of the battery, and what was used or charged since the last time."""
        if self.charge is not None:
            change = charge - self.charge
            self.used, self.charged = self.used + max(0.0, -change), self.charged + max(0.0, change)
        self.charge = charge
        self.measure(at, share)

    def measure(self, at: int, share: float) -> None:
        """Record the charge of the battery as a share of the capacity."""
        if not self.curve or self.curve[-1] != (at, share):
            self.curve.append((at, share))


class RobotLog:
    """Keeps the record of each robot."""

    def __init__(self, timeline: Timeline) -> None:
        self.tracks: dict[str, Track] = {}
        self._timeline = timeline
        timeline.on(Spawned, self._spawned)
        timeline.on(Deleted, self._deleted)
        timeline.on(Teleported, self._teleported)

    def add(self, name: str, kind: str) -> None:
        """Record a robot that exists from the beginning."""
        self.tracks[name] = Track(name, kind, self._timeline.began or 0)

    def track(self, name: str, at: int, kind: str = "") -> Track:
        """Return the record of a robot, updated to a time."""
        track = self.tracks.get(name)
        if track is None:
            began = at if kind or self._timeline.began is None else self._timeline.began
            track = self.tracks[name] = Track(name, kind, began)
        elif track.ended is not None:
            # A robot of this name was added again.
            track.return_at(at)
        track.catch_up(at)
        return track

    def _spawned(self, at: int, event: Spawned) -> None:
        if event.type != "item":
            self.track(event.entity, at, event.type)

    def _deleted(self, at: int, event: Deleted) -> None:
        track = self.tracks.get(event.entity)
        if track is not None and track.ended is None:
            self._leave(track, at, event.kind)

    def _teleported(self, at: int, event: Teleported) -> None:
        track = self.tracks.get(event.entity)
        if track is not None and track.ended is None:
            track.catch_up(at)
            track.halt(at)
            track.settle(at)

    def reset(self, at: int, event: SimulationReset | WorldLoaded) -> None:
        """Record a reset: all robots are at their initial positions, and their states are published again."""
        for track in self.tracks.values():
            if track.ended is None:
                track.catch_up(at)
                track.stop_waiting(at, event.kind)
                track.halt(at)
                track.condition.clear()
                track.charge = None
                track.settle(at)

    def keep(self, names: set[str], at: int) -> None:
        """Record that all robots except those named were removed."""
        for track in self.tracks.values():
            if track.ended is None and track.name not in names:
                self._leave(track, at, "end")

    def _leave(self, track: Track, at: int, why: str) -> None:
        track.catch_up(at)
        track.stop_waiting(at, why)
        track.stop_queueing(at, why)
        track.leave(at)


class Waiting:
    """Records the waits of robots, on their way and in the queues of docks.

    Attributes:
        deadlocks: The time, robots and lanes of each deadlock.
    """

    def __init__(self, timeline: Timeline, robot_log: RobotLog, lanes: Lanes) -> None:
        self._robot_log = robot_log
        self._lanes = lanes
        self.deadlocks: list[tuple[int, tuple[str, ...], tuple[tuple[str, str], ...]]] = []
        timeline.on(events.Waiting, self._begin)
        timeline.on((events.WentOn, events.Rerouted, events.MadeRoom), self._end)
        timeline.on(DockQueued, self._queue)
        timeline.on(Docked, self._dock)
        timeline.on(events.Deadlock, self._lock)

    @property
    def wait_records(self) -> list[WaitRecord]:
        """All waits, in order of time."""
        stood = [wait for track in self._robot_log.tracks.values() for wait in track.stood]
        return sorted(stood, key=lambda wait: (wait.began, wait.robot))

    def _begin(self, at: int, event: events.Waiting) -> None:
        track = self._robot_log.track(event.robot, at)
        since = track.wait.since if track.wait else at
        track.stop_waiting(at, event.kind)
        track.halt(at, event.at)
        robots = event.for_ or ()
        closed = event.lane is not None and self._lanes.is_closed(event.lane)
        goal = track.goal
        track.wait = WaitRecord(
            track.name, at, "way", robots, event.why, event.lane, event.at, goal, since=since, closed=closed
        )
        track.settle(at)

    def _end(self, at: int, event: events.WentOn | events.Rerouted | events.MadeRoom) -> None:
        track = self._robot_log.track(event.robot, at)
        track.stop_waiting(at, event.kind)
        track.aside = None
        if isinstance(event, events.MadeRoom):
            # A robot that queues for a dock keeps its place.
            by = (event.by,) if event.by else ()
            track.aside = track.queued or WaitRecord(track.name, at, "way", by, goal=track.goal)
        if isinstance(event, events.Rerouted) and track.goal is not None:
            track.goal.reroutes += 1
        track.settle(at)

    def _queue(self, at: int, event: DockQueued) -> None:
        track = self._robot_log.track(event.robot, at)
        track.stop_queueing(at, events.Waiting.kind)
        track.queued = WaitRecord(track.name, at, "dock", why=event.dock, goal=track.goal)

    def _dock(self, at: int, event: Docked) -> None:
        self._robot_log.track(event.robot, at).stop_queueing(at, "docked")

    def _lock(self, at: int, event: events.Deadlock) -> None:
        self.deadlocks.append((at, event.robots, event.lanes))
        for name in event.robots:
            track = self._robot_log.tracks.get(name)
            for goal in track.running.values() if track else ():
                goal.deadlock = True
