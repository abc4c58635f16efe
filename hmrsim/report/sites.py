"""How doors, lifts and docks were used, and when lanes were closed; times in nanoseconds."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from hmrsim.report.occurrence import lane, records, text, texts, whole

if TYPE_CHECKING:
    from collections.abc import Mapping


@dataclass(slots=True)
class Use:
    """How one of them was used: how often, by whom, how long."""

    uses: int = 0
    robots: set[str] = field(default_factory=set)
    time: int = 0
    queue: int = 0
    inside: set[str] = field(default_factory=set)
    since: int | None = None

    def begin(self, at: int) -> None:
        """Take note that it is in use from now on."""
        if self.since is None:
            self.since = at

    def end(self, at: int) -> None:
        """Take note that it is in use no longer."""
        if self.since is not None:
            self.time, self.since = self.time + at - self.since, None


@dataclass(slots=True)
class Sites:
    """All of a run, by kind and name."""

    doors: dict[str, Use] = field(default_factory=lambda: defaultdict(Use))
    lifts: dict[str, Use] = field(default_factory=lambda: defaultdict(Use))
    docks: dict[str, Use] = field(default_factory=lambda: defaultdict(Use))
    closed: dict[tuple[str, str], Use] = field(default_factory=lambda: defaultdict(Use))

    def take(self, kind: str, at: int, fields: Mapping[str, Any]) -> None:
        """Take note of what happened, if it concerns one of them."""
        if kind.startswith("door_"):
            self._door(kind, at, fields)
        elif kind.startswith("lift_"):
            self._lift(kind, at, fields)
        elif kind.startswith("dock_"):
            self._dock(kind, at, fields)
        elif kind in ("lane_closed", "lane_opened"):
            named = lane(fields)
            if named is not None:
                use = self.closed[named]
                (use.begin if kind == "lane_closed" else use.end)(at)

    def see(self, at: int, scene: Mapping[str, Any]) -> None:
        """Take over what a scene says."""
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
            named = lane(closed)
            if named is not None:
                self.closed[named].begin(at)

    def end(self, at: int) -> None:
        """Take note that the run has ended."""
        for use in (use for kind in (self.doors, self.lifts, self.docks, self.closed) for use in kind.values()):
            use.end(at)

    def _door(self, kind: str, at: int, fields: Mapping[str, Any]) -> None:
        use, by = self.doors[text(fields, "door")], text(fields, "by", "")
        if by:
            use.robots.add(by)
        if kind == "door_opening":
            use.uses += 1
        elif kind == "door_opened":
            use.begin(at)
        elif kind == "door_closed":
            use.end(at)

    def _lift(self, kind: str, at: int, fields: Mapping[str, Any]) -> None:
        use = self.lifts[text(fields, "lift")]
        use.robots |= {*texts(fields, "robots")}
        if kind == "lift_departed":
            use.uses += 1
            use.begin(at)
        elif kind == "lift_arrived":
            use.end(at)

    def _dock(self, kind: str, at: int, fields: Mapping[str, Any]) -> None:
        use, robot = self.docks[text(fields, "dock")], text(fields, "robot")
        if kind == "dock_queued":
            use.queue = max(use.queue, whole(fields, "position"))
        elif kind == "dock_docked":
            use.uses += 1
            use.robots.add(robot)
            use.inside.add(robot)
            use.begin(at)
        elif kind == "dock_undocked":
            use.inside.discard(robot)
            if not use.inside:
                use.end(at)
