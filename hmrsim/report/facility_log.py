"""The usage of doors, lifts and docks, and the closures of lanes; times in nanoseconds."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from hmrsim.events.facilities import DoorClosed, DoorOpened, DoorOpening, LiftArrived, LiftCalled, LiftDeparted
from hmrsim.events.robots import Docked, DockQueued, Undocked
from hmrsim.events.traffic import LaneClosed, LaneOpened
from hmrsim.history.occurrence import lane as lane_of
from hmrsim.history.occurrence import records, text, texts


@dataclass(slots=True)
class Use:
    """The usage of one door, lift or dock."""

    uses: int = 0
    robots: set[str] = field(default_factory=set)
    time: int = 0
    queue: int = 0
    inside: set[str] = field(default_factory=set)
    since: int | None = None

    def begin(self, at: int) -> None:
        """Record that it is in use from now on."""
        if self.since is None:
            self.since = at

    def end(self, at: int) -> None:
        """Record that it is no longer in use."""
        if self.since is not None:
            self.time, self.since = self.time + at - self.since, None


@dataclass(slots=True)
class FacilityLog:
    """All of a run, by kind and name."""

    doors: dict[str, Use] = field(default_factory=lambda: defaultdict(Use))
    lifts: dict[str, Use] = field(default_factory=lambda: defaultdict(Use))
    docks: dict[str, Use] = field(default_factory=lambda: defaultdict(Use))
    closed: dict[tuple[str, str], Use] = field(default_factory=lambda: defaultdict(Use))

    def take(self, at: int, event: object) -> None:
        """Record an event, if it concerns one of them."""
        match event:
            case DoorOpening() | DoorOpened() | DoorClosed():
                self._door(at, event)
            case LiftCalled() | LiftDeparted() | LiftArrived():
                self._lift(at, event)
            case DockQueued() | Docked() | Undocked():
                self._dock(at, event)
            case LaneClosed(lane):
                self.closed[lane].begin(at)
            case LaneOpened(lane):
                self.closed[lane].end(at)

    def see(self, at: int, scene: Mapping[str, Any]) -> None:
        """Start from the state of a scene."""
        for use in (use for kind in (self.doors, self.lifts, self.docks, self.closed) for use in kind.values()):
            use.end(at)
            use.inside.clear()
        for robot in records(scene, "robots"):
            if isinstance(robot.get("dock"), str):
                use = self.docks[robot["dock"]]
                use.inside.add(text(robot, "name"))
                use.begin(at)
        for fixture in records(scene, "fixtures"):
            if fixture.get("kind") == "door" and "open" in texts(fixture, "tags"):
                self.doors[text(fixture, "name")].begin(at)
        for closed in records(scene, "closed_lanes"):
            named = lane_of(closed)
            if named is not None:
                self.closed[named].begin(at)

    def end(self, at: int) -> None:
        """Record the end of the run."""
        for use in (use for kind in (self.doors, self.lifts, self.docks, self.closed) for use in kind.values()):
            use.end(at)

    def _door(self, at: int, event: DoorOpening | DoorOpened | DoorClosed) -> None:
        use = self.doors[event.door]
        if not isinstance(event, DoorClosed) and event.by:
            use.robots.add(event.by)
        match event:
            case DoorOpening():
                use.uses += 1
            case DoorOpened():
                use.begin(at)
            case DoorClosed():
                use.end(at)

    def _lift(self, at: int, event: LiftCalled | LiftDeparted | LiftArrived) -> None:
        use = self.lifts[event.lift]
        match event:
            case LiftDeparted(robots=robots):
                use.robots |= {*robots}
                use.uses += 1
                use.begin(at)
            case LiftArrived(robots=robots):
                use.robots |= {*robots}
                use.end(at)

    def _dock(self, at: int, event: DockQueued | Docked | Undocked) -> None:
        use = self.docks[event.dock]
        match event:
            case DockQueued(position=position):
                use.queue = max(use.queue, position)
            case Docked(robot=robot):
                use.uses += 1
                use.robots.add(robot)
                use.inside.add(robot)
                use.begin(at)
            case Undocked(robot=robot):
                use.inside.discard(robot)
                if not use.inside:
                    use.end(at)
