"""The robots of a run: when each was present, their faults and their waits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from hmrsim.events import traffic as events
from hmrsim.report.goals import WaitRecord
from hmrsim.report.track import Track

if TYPE_CHECKING:
    from hmrsim.events.faults import FaultBegan
    from hmrsim.events.robots import Docked, DockQueued
    from hmrsim.events.simulation import Deleted, SimulationReset, Spawned, Teleported, WorldLoaded


@dataclass
class RobotLog:
    """Keeps an account of each robot.

    Attributes:
        began: When the run began; None before the first occurrence.
    """

    tracks: dict[str, Track] = field(default_factory=dict)
    began: int | None = None

    def add(self, name: str, kind: str) -> None:
        """Record a robot that exists from the beginning."""
        self.tracks[name] = Track(name, kind, self.began or 0)

    def track(self, name: str, at: int, kind: str = "") -> Track:
        """Return the account of a robot, up to date."""
        track = self.tracks.get(name)
        if track is None:
            began = at if kind or self.began is None else self.began
            track = self.tracks[name] = Track(name, kind, began)
        elif track.ended is not None:
            # A robot of this name was added again.
            track.return_at(at)
        track.catch_up(at)
        return track

    def spawned(self, at: int, event: Spawned) -> None:
        """Record an added robot."""
        if event.type != "item":
            self.track(event.entity, at, event.type)

    def deleted(self, at: int, event: Deleted) -> None:
        """Record a removed robot."""
        track = self.tracks.get(event.entity)
        if track is not None and track.ended is None:
            self._leave(track, at, event.kind)

    def teleported(self, at: int, event: Teleported) -> None:
        """Record a robot that was teleported."""
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
                track.disabled_reasons, track.cut_off, track.charging, track.charge = set(), set(), False, None
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


@dataclass(slots=True)
class FaultRecord:
    """A fault that has begun; *robot* is empty for a fault of another subject."""

    name: str
    fault: str
    robot: str
    settings: Mapping[str, Any]
    began: int
    ended: int | None = None


@dataclass(slots=True)
class FaultLog:
    """All faults, in order, and the active ones."""

    all: list[FaultRecord] = field(default_factory=list)
    going_on: dict[str, FaultRecord] = field(default_factory=dict)

    def begin(self, at: int, event: FaultBegan) -> FaultRecord:
        """Record that a fault has begun, and return it."""
        fault = FaultRecord(event.name, event.fault, event.robot, event.settings, at)
        self.all.append(fault)
        self.going_on[fault.name] = fault
        return fault

    def end(self, at: int, name: str) -> FaultRecord | None:
        """Record that a fault has ended, and return it if it was known."""
        fault = self.going_on.pop(name, None)
        if fault is not None:
            fault.ended = at
        return fault

    def at(self, robot: str) -> tuple[str, ...]:
        """Return the names of the active faults that may affect a robot: its own, and those without a robot."""
        return tuple(name for name, fault in self.going_on.items() if fault.robot in ("", robot))


def hit(fault: FaultRecord, track: Track, *, begins: bool) -> None:
    """Record the effect of a fault on the state of its robot."""
    hurt = {"breakdown": track.disabled_reasons, "messages_lost": track.cut_off}.get(fault.fault)
    if hurt is not None:
        (hurt.add if begins else hurt.discard)(fault.name)


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
