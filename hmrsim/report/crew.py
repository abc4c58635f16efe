"""The robots of a run: who was there from when to when."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from hmrsim.report.occurrence import text
from hmrsim.report.track import Track

if TYPE_CHECKING:
    from hmrsim.report.occurrence import Occurrence


@dataclass
class Crew:
    """Keeps an account of each robot.

    Attributes:
        tracks: The accounts, by name.
        began: When the run began; None before anything has happened.
    """

    tracks: dict[str, Track] = field(default_factory=dict)
    began: int | None = None

    def add(self, name: str, kind: str) -> None:
        """Take note of a robot that is there from the beginning."""
        self.tracks[name] = Track(name, kind, self.began or 0)

    def track(self, name: str, at: int, kind: str = "") -> Track:
        """Return the account of a robot, caught up."""
        track = self.tracks.get(name)
        if track is None:
            began = at if kind or self.began is None else self.began
            track = self.tracks[name] = Track(name, kind, began)
        elif track.ended is not None:
            # One of its name has come again.
            track.return_at(at)
        track.catch_up(at)
        return track

    def spawned(self, event: Occurrence) -> None:
        """Take note of who has come."""
        if text(event.fields, "type", "") != "item":
            self.track(text(event.fields, "entity"), event.at, text(event.fields, "type", ""))

    def deleted(self, event: Occurrence) -> None:
        """Take note of who has gone."""
        track = self.tracks.get(text(event.fields, "entity"))
        if track is not None and track.ended is None:
            self._leave(track, event.at, "deleted")

    def teleported(self, event: Occurrence) -> None:
        """Take note of who was put elsewhere."""
        track = self.tracks.get(text(event.fields, "entity"))
        if track is not None and track.ended is None:
            track.catch_up(event.at)
            track.halt(event.at)
            track.settle(event.at)

    def begin_anew(self, event: Occurrence) -> None:
        """Take note that all were put where they begin; what holds of them is told anew."""
        for track in self.tracks.values():
            if track.ended is None:
                track.catch_up(event.at)
                track.stand_no_more(event.at, event.kind)
                track.halt(event.at)
                track.ailments, track.cut_off, track.charging, track.charge = set(), set(), False, None
                track.settle(event.at)

    def keep(self, names: set[str], at: int) -> None:
        """Take note that all others are there no longer."""
        for track in self.tracks.values():
            if track.ended is None and track.name not in names:
                self._leave(track, at, "end")

    def _leave(self, track: Track, at: int, why: str) -> None:
        track.catch_up(at)
        track.stand_no_more(at, why)
        track.stop_queueing(at, why)
        track.leave(at)
