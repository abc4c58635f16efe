"""What happened in a run, put together from one occurrence after the other."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

from hmrsim.goal import GoalStatus
from hmrsim.report.book import Book
from hmrsim.report.occurrence import Misfit, Occurrence, lane, number, point, records, text, texts, whole
from hmrsim.report.sites import Sites
from hmrsim.report.track import Motion, Standing, Track
from hmrsim.report.troubles import Trouble, Troubles, hit

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

_UNTOLD: Final = {"scene", "battery", "motion", "route", "goal"}
"""Kinds that are no events for people."""

_SAMPLED: Final = {"scene", "battery"}
"""Kinds that may come late, so that they do not tell that time began anew."""

_EMPTY: Final = "battery_empty"
_OF_BATTERIES: Final = (
    "battery_low",
    "battery_critical",
    _EMPTY,
    "battery_revived",
    "battery_full",
    "charging_began",
    "charging_ended",
)


@dataclass
class Story:
    """Takes occurrences in order of time, and keeps what a report says of them.

    Time that began anew goes on where it was; so all times are nanoseconds since the run began.

    Attributes:
        tracks: The robots, by name.
        book: The goals.
        sites: Doors, lifts, docks and closed lanes.
        began: When the first thing happened.
        now: When the last thing happened.
    """

    tracks: dict[str, Track] = field(default_factory=dict)
    book: Book = field(default_factory=Book)
    sites: Sites = field(default_factory=Sites)
    troubles: Troubles = field(default_factory=Troubles)
    deadlocks: list[tuple[int, tuple[str, ...], tuple[tuple[str, str], ...]]] = field(default_factory=list)
    counts: Counter[str] = field(default_factory=Counter)
    misfits: int = 0
    first_misfit: str = ""
    began: int | None = None
    now: int = 0
    restarts: int = 0
    _offset: int = 0
    _anew: bool = True

    def __post_init__(self) -> None:
        """Say who takes note of what."""
        self._takers: dict[str, Callable[[Occurrence], None]] = {
            "scene": self._scene,
            "motion": self._motion,
            "stopped": self._stopped,
            "teleported": self._teleported,
            "goal": self.book.ask_of,
            "command": self.book.ask_of,
            "status": self._status,
            "rejected": self._rejected,
            "waiting": self._waiting,
            "went_on": self._no_longer,
            "rerouted": self._no_longer,
            "made_room": self._no_longer,
            "dock_queued": self._queue,
            "dock_docked": self._docked,
            "deadlock": self._deadlock,
            "battery": self._battery,
            **dict.fromkeys(_OF_BATTERIES, self._told_battery),
            "fault_began": self._fault_began,
            "fault_ended": self._fault_ended,
            "spawned": self._spawned,
            "deleted": self._deleted,
            "reset": self._begun_anew,
            "world_loaded": self._begun_anew,
        }

    def take(self, happened: Occurrence) -> None:
        """Take note of what happened; what can't be understood is left out, and counted."""
        try:
            self._take(happened)
        except (Misfit, ValueError) as error:
            self.misfits += 1
            self.first_misfit = self.first_misfit or f"{happened.kind}: {error}"

    def end(self, at: int | None = None) -> None:
        """Take note that the run has ended, at some time or when the last thing happened."""
        if at is not None and at + self._offset > self.now:
            self.now = at + self._offset
        for track in self.tracks.values():
            if track.ended is None:
                self._leave(track, "end")
        self.sites.end(self.now)

    def add(self, name: str, kind: str) -> None:
        """Take note of a robot that is there from the beginning."""
        self.tracks[name] = Track(name, kind, self.began or 0)

    @property
    def seen(self) -> bool:
        """Whether it was seen what there was in the beginning."""
        return not self._anew

    @property
    def standings(self) -> list[Standing]:
        """All waits, in order of time."""
        stood = [standing for track in self.tracks.values() for standing in track.stood]
        return sorted(stood, key=lambda standing: (standing.began, standing.robot))

    @property
    def metered(self) -> bool:
        """Whether it is known what is in any battery."""
        return any(track.charge is not None for track in self.tracks.values())

    # --- taking ---------------------------------------------------------------------------------------------------

    def _take(self, happened: Occurrence) -> None:
        # A stamp of one nanosecond is that of time 0, which ROS could not tell from none.
        at = (0 if happened.at == 1 else happened.at) + self._offset
        if self.began is None:
            self.began = self.now = at
        if at < self.now and happened.kind in _SAMPLED:
            at = self.now
        if at < self.now:
            self._offset += self.now - at
            self.restarts += 1
            at = self.now
        self.now = at
        if happened.kind not in _UNTOLD:
            self.counts[happened.kind] += 1
        taker = self._takers.get(happened.kind)
        if taker is not None:
            taker(happened._replace(at=at))
        self.sites.take(happened.kind, at, happened.fields)

    def _track(self, name: str, at: int, kind: str = "") -> Track:
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

    def _scene(self, event: Occurrence) -> None:
        said = records(event.fields, "robots")
        names = {text(robot, "name") for robot in said}
        for track in self.tracks.values():
            if self._anew and track.ended is None and track.name not in names:
                self._leave(track, "end")
        for robot in said:
            known = self.tracks.get(text(robot, "name"))
            if self._anew or known is None or known.ended is not None:
                self._see(robot, event.at, gone=not self._anew)
        if self._anew:
            for fault in records(event.fields, "faults"):
                self._hit(self.troubles.begin(event.at, fault), event.at, begins=True)
            self.sites.see(event.at, event.fields)
        self._anew = False

    def _see(self, robot: Mapping[str, Any], at: int, *, gone: bool) -> None:
        """Take over what a scene says of a robot."""
        track = self._track(text(robot, "name"), at, text(robot, "type", "") if gone else "")
        track.type = text(robot, "type", "")
        track.halt(at)
        # What else ails it are faults, of which the scene tells by itself.
        ailments, battery = robot.get("ailments"), robot.get("battery")
        track.ailments = {_EMPTY} if isinstance(ailments, dict) and _EMPTY in ailments else set()
        if isinstance(battery, dict):
            track.measure(at, number(battery, "percentage"))
            track.charging = bool(battery.get("charging"))
        for goal in records(robot, "goals"):
            if not GoalStatus(whole(goal, "status")).terminal:
                self.book.ask(goal)
                self._status(Occurrence(at, "status", goal))
        motion = robot.get("motion")
        if isinstance(motion, dict):
            began = motion.get("began")
            since = round(number(motion, "began") * 1e9) + self._offset if began is not None else at
            track.go(Motion.of(min(since, at), motion, track.goal))
        elif robot.get("waits"):
            track.standing = Standing(track.name, at, "way", goal=track.goal)
        track.settle(at)

    def _motion(self, event: Occurrence) -> None:
        track = self._track(text(event.fields, "robot"), event.at)
        track.stand_no_more(self.now, "went_on")
        track.stop_queueing(self.now, "went_on")
        track.go(Motion.of(event.at, event.fields, track.goal))
        track.settle(event.at)

    def _stopped(self, event: Occurrence) -> None:
        track = self._track(text(event.fields, "robot"), event.at)
        track.stand_no_more(self.now, "stopped")
        track.halt(event.at, point(event.fields, "at"))
        track.settle(event.at)

    def _status(self, event: Occurrence) -> None:
        goal = self.book.change(event)
        track = self._track(goal.robot, event.at)
        if goal.ended is None:
            track.running[goal.goal_id] = goal
        else:
            track.running.pop(goal.goal_id, None)
            goal.waiting = track.waiting_for(goal, event.at)
            goal.faults = self.troubles.at(goal.robot)
            if track.queued is not None and track.queued.goal is goal:
                track.stop_queueing(self.now, "end")
        track.settle(event.at)

    def _rejected(self, event: Occurrence) -> None:
        faults = self.troubles.at(text(event.fields, "robot", ""))
        self.book.rejected.append((event.at, {**event.fields, "faults": faults}))

    # --- waiting --------------------------------------------------------------------------------------------------

    def _waiting(self, event: Occurrence) -> None:
        fields = event.fields
        track = self._track(text(fields, "robot"), event.at)
        track.stand_no_more(self.now, "waiting")
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

    def _no_longer(self, event: Occurrence) -> None:
        track = self._track(text(event.fields, "robot"), event.at)
        track.stand_no_more(self.now, event.kind)
        if event.kind == "rerouted" and track.goal is not None:
            track.goal.reroutes += 1
        track.settle(event.at)

    def _queue(self, event: Occurrence) -> None:
        track = self._track(text(event.fields, "robot"), event.at)
        track.stop_queueing(self.now, "waiting")
        dock = text(event.fields, "dock")
        track.queued = Standing(track.name, event.at, "dock", why=dock, goal=track.goal)

    def _docked(self, event: Occurrence) -> None:
        self._track(text(event.fields, "robot"), event.at).stop_queueing(event.at, "docked")

    def _deadlock(self, event: Occurrence) -> None:
        robots = texts(event.fields, "robots")
        said = event.fields.get("lanes", [])
        lanes = [lane({"lane": each}) for each in said] if isinstance(said, list) else []
        self.deadlocks.append((event.at, robots, tuple(each for each in lanes if each)))
        for name in robots:
            track = self.tracks.get(name)
            for goal in track.running.values() if track else ():
                goal.deadlock = True

    # --- energy and faults ----------------------------------------------------------------------------------------

    def _battery(self, event: Occurrence) -> None:
        track, share = self._track(text(event.fields, "robot"), event.at), number(event.fields, "percentage")
        if event.fields.get("charge") is None:
            track.measure(event.at, share)
        else:
            track.weigh(event.at, number(event.fields, "charge"), share)

    def _told_battery(self, event: Occurrence) -> None:
        track = self._track(text(event.fields, "robot"), event.at)
        track.measure(event.at, number(event.fields, "percentage"))
        if event.kind == _EMPTY:
            track.ailments.add(event.kind)
        elif event.kind == "battery_revived":
            track.ailments.discard(_EMPTY)
        elif event.kind.startswith("charging_"):
            track.charging = event.kind == "charging_began"
        track.settle(event.at)

    def _fault_began(self, event: Occurrence) -> None:
        self._hit(self.troubles.begin(event.at, event.fields), event.at, begins=True)

    def _fault_ended(self, event: Occurrence) -> None:
        self._hit(self.troubles.end(event.at, text(event.fields, "name")), event.at, begins=False)

    def _hit(self, trouble: Trouble | None, at: int, *, begins: bool) -> None:
        if trouble is not None and trouble.robot in self.tracks:
            track = self._track(trouble.robot, at)
            hit(trouble, track, begins=begins)
            track.settle(at)

    # --- who is there ---------------------------------------------------------------------------------------------

    def _spawned(self, event: Occurrence) -> None:
        if text(event.fields, "type", "") != "item":
            self._track(text(event.fields, "entity"), event.at, text(event.fields, "type", ""))

    def _deleted(self, event: Occurrence) -> None:
        track = self.tracks.get(text(event.fields, "entity"))
        if track is not None and track.ended is None:
            self._leave(track, "deleted")

    def _leave(self, track: Track, why: str) -> None:
        track.catch_up(self.now)
        track.stand_no_more(self.now, why)
        track.stop_queueing(self.now, why)
        track.leave(self.now)

    def _teleported(self, event: Occurrence) -> None:
        track = self.tracks.get(text(event.fields, "entity"))
        if track is not None and track.ended is None:
            track.catch_up(event.at)
            track.halt(event.at)
            track.settle(event.at)

    def _begun_anew(self, event: Occurrence) -> None:
        self._anew = True
        self.troubles.going_on.clear()
        for track in self.tracks.values():
            if track.ended is None:
                track.catch_up(event.at)
                track.stand_no_more(self.now, event.kind)
                track.halt(event.at)
                track.ailments, track.cut_off, track.charging, track.charge = set(), set(), False, None
                track.settle(event.at)
