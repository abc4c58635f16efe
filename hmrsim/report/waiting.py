"""The waits between robots and for resources, and the deadlocks among them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from hmrsim.events import traffic as events
from hmrsim.report.goal_record import WaitRecord

if TYPE_CHECKING:
    from hmrsim.events.robots import Docked, DockQueued
    from hmrsim.report.robot_log import RobotLog


@dataclass
class Waiting:
    """Records robots that wait on their way, or in the queue of a dock.

    Attributes:
        deadlocks: Their times, robots and lanes.
    """

    robot_log: RobotLog
    deadlocks: list[tuple[int, tuple[str, ...], tuple[tuple[str, str], ...]]] = field(default_factory=list)

    @property
    def wait_records(self) -> list[WaitRecord]:
        """All waits, in order of time."""
        stood = [wait for track in self.robot_log.tracks.values() for wait in track.stood]
        return sorted(stood, key=lambda wait: (wait.began, wait.robot))

    def begin(self, at: int, event: events.Waiting) -> None:
        """Record a robot that waits on its way, or goes on waiting for something else."""
        track = self.robot_log.track(event.robot, at)
        since = track.wait.since if track.wait else at
        track.stand_no_more(at, event.kind)
        track.halt(at, event.at)
        robots = event.for_ or ()
        track.wait = WaitRecord(track.name, at, "way", robots, event.why, event.lane, event.at, track.goal, since=since)
        track.settle(at)

    def end(self, at: int, event: events.WentOn | events.Rerouted | events.MadeRoom) -> None:
        """Record a robot that continues, or takes another route."""
        track = self.robot_log.track(event.robot, at)
        track.stand_no_more(at, event.kind)
        if isinstance(event, events.Rerouted) and track.goal is not None:
            track.goal.reroutes += 1
        track.settle(at)

    def queue(self, at: int, event: DockQueued) -> None:
        """Record a robot in the queue of a dock."""
        track = self.robot_log.track(event.robot, at)
        track.stop_queueing(at, events.Waiting.kind)
        track.queued = WaitRecord(track.name, at, "dock", why=event.dock, goal=track.goal)

    def dock(self, at: int, event: Docked) -> None:
        """Record a robot that has left the queue for its bay."""
        self.robot_log.track(event.robot, at).stop_queueing(at, "docked")

    def lock(self, at: int, event: events.Deadlock) -> None:
        """Record a deadlock."""
        self.deadlocks.append((at, event.robots, event.lanes))
        for name in event.robots:
            track = self.robot_log.tracks.get(name)
            for goal in track.running.values() if track else ():
                goal.deadlock = True
