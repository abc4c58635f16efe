"""The robots of a run: when each was present, and their waits."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.events import traffic as events
from hmrsim.events.robots import Docked, DockQueued
from hmrsim.events.simulation import Deleted, Spawned, Teleported
from hmrsim.report.goals import WaitRecord
from hmrsim.report.track import Track

if TYPE_CHECKING:
    from hmrsim.events.simulation import SimulationReset, WorldLoaded
    from hmrsim.history.timeline import Timeline


class RobotLog:
    """Keeps an account of each robot."""

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
        """Return the account of a robot, up to date."""
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
        """Record a reset: all robots are at their start, and their states are published again."""
        for track in self.tracks.values():
            if track.ended is None:
                track.catch_up(at)
                track.stand_no_more(at, event.kind)
                track.halt(at)
                track.condition.clear()
                track.charge = None
                track.settle(at)

    def keep(self, names: set[str], at: int) -> None:
        """Record that all others were removed."""
        for track in self.tracks.values():
            if track.ended is None and track.name not in names:
                self._leave(track, at, "end")

    def _leave(self, track: Track, at: int, why: str) -> None:
        track.catch_up(at)
        track.stand_no_more(at, why)
        track.stop_queueing(at, why)
        track.leave(at)


class Waiting:
    """Records robots that wait on their way, or in the queue of a dock.

    Attributes:
        deadlocks: Their times, robots and lanes.
    """

    def __init__(self, timeline: Timeline, robot_log: RobotLog) -> None:
        self._robot_log = robot_log
        self.deadlocks: list[tuple[int, tuple[str, ...], tuple[tuple[str, str], ...]]] = []
        timeline.on(events.Waiting, self._begin)
        for ends in (events.WentOn, events.Rerouted, events.MadeRoom):
            timeline.on(ends, self._end)
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
        track.stand_no_more(at, event.kind)
        track.halt(at, event.at)
        robots = event.for_ or ()
        track.wait = WaitRecord(track.name, at, "way", robots, event.why, event.lane, event.at, track.goal, since=since)
        track.settle(at)

    def _end(self, at: int, event: events.WentOn | events.Rerouted | events.MadeRoom) -> None:
        track = self._robot_log.track(event.robot, at)
        track.stand_no_more(at, event.kind)
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
