"""The robots of a run, and when each was present."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from hmrsim.report.track import Track

if TYPE_CHECKING:
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
