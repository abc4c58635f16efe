"""What happened in a run, put together from one occurrence after the other."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

from hmrsim.engine.sim_time import JITTER
from hmrsim.protocol.goal import GoalStatus
from hmrsim.report.book import Book
from hmrsim.report.crew import Crew
from hmrsim.report.occurrence import Misfit, Occurrence, number, point, records, text, whole
from hmrsim.report.pursuit import Standing
from hmrsim.report.sites import Sites
from hmrsim.report.track import Motion, Track
from hmrsim.report.troubles import Trouble, Troubles, hit
from hmrsim.report.waiting import Waiting

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

_UNTOLD: Final = {"scene", "battery", "commanded", "motion", "route", "goal"}
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
        crew: The robots.
        book: The goals.
        sites: Doors, lifts, docks and closed lanes.
        waiting: Who waited.
        now: When the last thing happened.
    """

    crew: Crew = field(default_factory=Crew)
    book: Book = field(default_factory=Book)
    sites: Sites = field(default_factory=Sites)
    troubles: Troubles = field(default_factory=Troubles)
    counts: Counter[str] = field(default_factory=Counter)
    misfits: int = 0
    first_misfit: str = ""
    now: int = 0
    restarts: int = 0
    _offset: int = 0
    _anew: bool = True

    def __post_init__(self) -> None:
        """Say who takes note of what."""
        crew, self.waiting = self.crew, Waiting(self.crew)
        self._takers: dict[str, Callable[[Occurrence], None]] = {
            "scene": self._scene,
            "motion": self._motion,
            "stopped": self._stopped,
            "teleported": crew.teleported,
            "goal": self.book.ask_of,
            "command": self.book.ask_of,
            "status": self._status,
            "rejected": self._rejected,
            "waiting": self.waiting.begin,
            **dict.fromkeys(("went_on", "rerouted", "made_room"), self.waiting.end),
            "dock_queued": self.waiting.queue,
            "dock_docked": self.waiting.dock,
            "deadlock": self.waiting.lock,
            "battery": self._battery,
            **dict.fromkeys(_OF_BATTERIES, self._told_battery),
            "fault_began": self._fault_began,
            "fault_ended": self._fault_ended,
            "spawned": crew.spawned,
            "deleted": crew.deleted,
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
        self.crew.keep(set(), self.now)
        self.sites.end(self.now)

    @property
    def began(self) -> int | None:
        """When the first thing happened."""
        return self.crew.began

    @property
    def seen(self) -> bool:
        """Whether it was seen what there was in the beginning."""
        return not self._anew

    @property
    def metered(self) -> bool:
        """Whether it is known what is in any battery."""
        return any(track.charge is not None for track in self.crew.tracks.values())

    # --- taking ---------------------------------------------------------------------------------------------------

    def _take(self, happened: Occurrence) -> None:
        # A stamp of one nanosecond is that of time 0, which ROS could not tell from none.
        at = (0 if happened.at == 1 else happened.at) + self._offset
        if self.crew.began is None:
            self.crew.began = self.now = at
        if happened.kind in _SAMPLED or at >= self.now - JITTER:
            at = max(at, self.now)
        else:
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

    def _scene(self, event: Occurrence) -> None:
        said = records(event.fields, "robots")
        names = {text(robot, "name") for robot in said}
        if self._anew:
            self.crew.keep(names, event.at)
        for robot in said:
            known = self.crew.tracks.get(text(robot, "name"))
            if self._anew or known is None or known.ended is not None:
                self._see(robot, event.at, gone=not self._anew)
        if self._anew:
            for fault in records(event.fields, "faults"):
                self._hit(self.troubles.begin(event.at, fault), event.at, begins=True)
            self.sites.see(event.at, event.fields)
        self._anew = False

    def _see(self, robot: Mapping[str, Any], at: int, *, gone: bool) -> None:
        """Take over what a scene says of a robot."""
        track = self.crew.track(text(robot, "name"), at, text(robot, "type", "") if gone else "")
        track.type = text(robot, "type", "")
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
        motion = self._motion_in(robot, at, track)
        # It may have been told already that it drives, or waits.
        if motion is None or not track.drives(motion):
            track.halt(at)
            if motion is not None:
                track.go(motion)
        if motion is None and robot.get("waits") and track.standing is None:
            track.standing = Standing(track.name, at, "way", goal=track.goal)
        track.settle(at)

    def _motion_in(self, robot: Mapping[str, Any], at: int, track: Track) -> Motion | None:
        """Return how a robot moves in a scene."""
        motion = robot.get("motion")
        if not isinstance(motion, dict):
            return None
        began = motion.get("began")
        since = round(number(motion, "began") * 1e9) + self._offset if began is not None else at
        return Motion.of(min(since, at), motion, track.goal)

    def _motion(self, event: Occurrence) -> None:
        track = self.crew.track(text(event.fields, "robot"), event.at)
        track.stand_no_more(event.at, "went_on")
        track.stop_queueing(event.at, "went_on")
        track.go(Motion.of(event.at, event.fields, track.goal))
        track.settle(event.at)

    def _stopped(self, event: Occurrence) -> None:
        track = self.crew.track(text(event.fields, "robot"), event.at)
        track.stand_no_more(event.at, "stopped")
        track.halt(event.at, point(event.fields, "at"))
        track.settle(event.at)

    def _status(self, event: Occurrence) -> None:
        goal = self.book.change(event)
        track = self.crew.track(goal.robot, event.at)
        if goal.ended is None:
            track.running[goal.goal_id] = goal
        else:
            track.running.pop(goal.goal_id, None)
            goal.waiting = track.waiting_for(goal, event.at)
            goal.faults = self.troubles.at(goal.robot)
            if track.queued is not None and track.queued.goal is goal:
                track.stop_queueing(event.at, "end")
        track.settle(event.at)

    def _rejected(self, event: Occurrence) -> None:
        faults = self.troubles.at(text(event.fields, "robot", ""))
        self.book.rejected.append((event.at, {**event.fields, "faults": faults}))

    # --- energy and faults ----------------------------------------------------------------------------------------

    def _battery(self, event: Occurrence) -> None:
        track, share = self.crew.track(text(event.fields, "robot"), event.at), number(event.fields, "percentage")
        if event.fields.get("charge") is None:
            track.measure(event.at, share)
        else:
            track.weigh(event.at, number(event.fields, "charge"), share)

    def _told_battery(self, event: Occurrence) -> None:
        track = self.crew.track(text(event.fields, "robot"), event.at)
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
        if trouble is not None and trouble.robot in self.crew.tracks:
            track = self.crew.track(trouble.robot, at)
            hit(trouble, track, begins=begins)
            track.settle(at)

    def _begun_anew(self, event: Occurrence) -> None:
        self._anew = True
        self.troubles.going_on.clear()
        self.crew.begin_anew(event)
