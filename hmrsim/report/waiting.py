"""Who waited, for whom or what, and when none of them could go on any more."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from hmrsim.report.occurrence import lane, point, text, texts
from hmrsim.report.pursuit import Standing

if TYPE_CHECKING:
    from hmrsim.report.crew import Crew
    from hmrsim.report.occurrence import Occurrence


@dataclass
class Waiting:
    """Takes note of robots that stand on their way, or in the queue of a dock.

    Attributes:
        crew: The robots.
        deadlocks: When, which robots, on which lanes.
    """

    crew: Crew
    deadlocks: list[tuple[int, tuple[str, ...], tuple[tuple[str, str], ...]]] = field(default_factory=list)

    @property
    def standings(self) -> list[Standing]:
        """All waits, in order of time."""
        stood = [standing for track in self.crew.tracks.values() for standing in track.stood]
        return sorted(stood, key=lambda standing: (standing.began, standing.robot))

    def begin(self, event: Occurrence) -> None:
        """Take note of one that waits on its way."""
        fields = event.fields
        track = self.crew.track(text(fields, "robot"), event.at)
        track.stand_no_more(event.at, "waiting")
        track.halt(event.at, point(fields, "at"))
        track.standing = Standing(
            track.name,
            event.at,
            "way",
            texts(fields, "for"),
            text(fields, "why", ""),
            lane(fields),
            point(fields, "at"),
            track.goal,
        )
        track.settle(event.at)

    def end(self, event: Occurrence) -> None:
        """Take note of one that goes on, or elsewhere."""
        track = self.crew.track(text(event.fields, "robot"), event.at)
        track.stand_no_more(event.at, event.kind)
        if event.kind == "rerouted" and track.goal is not None:
            track.goal.reroutes += 1
        track.settle(event.at)

    def queue(self, event: Occurrence) -> None:
        """Take note of one in the queue of a dock."""
        track = self.crew.track(text(event.fields, "robot"), event.at)
        track.stop_queueing(event.at, "waiting")
        dock = text(event.fields, "dock")
        track.queued = Standing(track.name, event.at, "dock", why=dock, goal=track.goal)

    def dock(self, event: Occurrence) -> None:
        """Take note of one whose turn it was."""
        self.crew.track(text(event.fields, "robot"), event.at).stop_queueing(event.at, "docked")

    def lock(self, event: Occurrence) -> None:
        """Take note of some that wait for each other."""
        robots = texts(event.fields, "robots")
        said = event.fields.get("lanes", [])
        lanes = [lane({"lane": each}) for each in said] if isinstance(said, list) else []
        self.deadlocks.append((event.at, robots, tuple(each for each in lanes if each)))
        for name in robots:
            track = self.crew.tracks.get(name)
            for goal in track.running.values() if track else ():
                goal.deadlock = True
