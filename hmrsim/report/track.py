"""One robot's track through a run: its states over time, its distance and its waits."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from hmrsim.geometry import distance
from hmrsim.history.motion import INSTANT
from hmrsim.history.robots import Condition

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hmrsim.geometry import Point
    from hmrsim.history.motion import Motion
    from hmrsim.history.robots import State
    from hmrsim.report.goals import GoalRecord, WaitRecord


@dataclass(slots=True)
class LaneUse:
    """How a lane was used in one direction; times in nanoseconds."""

    drives: int = 0
    distance: float = 0.0
    time: int = 0


@dataclass(slots=True)
class Track:
    """The account of one robot.

    The caller changes its attributes; `settle` then records the resulting state.
    """

    name: str
    type: str
    began: int
    ended: int | None = None
    distance: float = 0.0
    charge: float | None = None
    used: float = 0.0
    charged: float = 0.0
    curve: list[tuple[int, float]] = field(default_factory=list)
    spans: list[tuple[int, int, State]] = field(default_factory=list)
    motion: Motion | None = None
    coming: Sequence[Motion] = ()
    wait: WaitRecord | None = None
    queued: WaitRecord | None = None
    stood: list[WaitRecord] = field(default_factory=list)
    condition: Condition = field(default_factory=Condition)
    running: dict[str, GoalRecord] = field(default_factory=dict)
    lanes: dict[tuple[str, str] | None, LaneUse] = field(default_factory=lambda: defaultdict(LaneUse))
    paths: dict[tuple[Point, Point], int] = field(default_factory=lambda: defaultdict(int))
    _state: State = "idle"
    _since: int = 0
    _last: Motion | None = None
    _pursued: GoalRecord | None = None

    def __post_init__(self) -> None:
        """Start at the point where it was added."""
        self._since = self.began

    @property
    def goal(self) -> GoalRecord | None:
        """The goal that holds its base, or any other that runs."""
        found = None
        for goal in self.running.values():
            if goal.holds_base or found is None:
                found = goal
        return found

    def waiting_for(self, goal: GoalRecord, at: int) -> WaitRecord | None:
        """Return what it waits for during a goal, or waited for until this instant."""
        for wait in (self.wait, self.queued, *self.stood[-1:]):
            if wait is not None and wait.goal is goal and wait.ended in (None, at):
                return wait
        return None

    def stand_no_more(self, at: int, until: str) -> None:
        """Record the end of its wait on its way, if it waited."""
        wait, self.wait = self.wait, None
        self._keep(wait, at, until)

    def stop_queueing(self, at: int, until: str) -> None:
        """Record that it has left the queue."""
        queued, self.queued = self.queued, None
        self._keep(queued, at, until)

    def _keep(self, wait: WaitRecord | None, at: int, until: str) -> None:
        """Keep a state that lasted for some time."""
        if wait is None or wait.began == at:
            return
        wait.ended, wait.until = at, until
        goes_on = any(part.since == wait.since and part.kind == wait.kind for part in self.stood[-1:])
        self.stood.append(wait)
        if wait.goal is not None:
            wait.goal.waits += not goes_on
            wait.goal.waited += at - wait.began

    def return_at(self, at: int) -> None:
        """Record that it was added again."""
        self.ended, self._since, self._state = None, at, "idle"

    def catch_up(self, at: int) -> None:
        """End the segments and states that have ended by some time without an event."""
        while (motion := self.motion) is not None and motion.until <= at + INSTANT:
            if self.coming:
                if motion.until >= at - INSTANT:
                    # One that stops here does not begin the next.
                    return
                self._go(*self.coming)
                continue
            ended = at if motion.until >= at - INSTANT else motion.until
            self.halt(ended, motion.end)
            self.settle(ended)

    def halt(self, at: int, where: Point | None = None) -> None:
        """End the current segment; *where* is the robot's point then, if that is known."""
        motion, self.coming = self.motion, ()
        if motion is None:
            return
        self.motion = None
        straight = motion.length > 0
        driven = min(motion.length, distance(motion.start, where)) if where and straight else motion.driven(at)
        self.distance += driven
        if self._pursued is not None:
            self._pursued.distance += driven
        if straight:
            use = self.lanes[motion.lane]
            use.distance += driven
            use.time += at - motion.began

    def drives(self, motion: Motion) -> bool:
        """Return whether it drives a segment already, judged by time and place."""
        known = self.motion
        return known is not None and known.end == motion.end and abs(known.began - motion.began) <= INSTANT

    def drive(self, motions: Sequence[Motion]) -> None:
        """Begin the segments of a motion for its goal; a current segment ends where they begin."""
        self.halt(motions[0].began, motions[0].start)
        self._pursued = self.goal
        self._go(*motions)

    def _go(self, motion: Motion, *coming: Motion) -> None:
        """Begin a segment, after which others come; a current one ends where this one begins."""
        self.halt(motion.began, motion.start)
        self.motion, self.coming = motion, coming
        if motion.length <= 0:
            return
        # A robot that continues at another speed is still on the same drive.
        last, self._last = self._last, motion
        if last is not None and (last.lane, last.end) == (motion.lane, motion.end) and last.start != motion.start:
            return
        self.lanes[motion.lane].drives += 1
        if motion.lane is None:
            a, b = sorted((round(x, 2), round(y, 2)) for x, y in (motion.start, motion.end))
            self.paths[a, b] += 1

    def settle(self, at: int) -> None:
        """Record its state from now on."""
        state = self.condition.state(
            waits=self.wait is not None, moves=self.motion is not None, busy=bool(self.running)
        )
        if state == self._state:
            return
        self._close(at)
        self._state, self._since = state, at

    def leave(self, at: int) -> None:
        """Record that it was removed, or that the run has ended."""
        self.catch_up(at)
        self.halt(at)
        self._close(at)
        self._since = at
        self.ended = at

    def _close(self, at: int) -> None:
        if at <= self._since:
            return
        if self.spans and self.spans[-1][2] == self._state and self.spans[-1][1] == self._since:
            self.spans[-1] = (self.spans[-1][0], at, self._state)
        else:
            self.spans.append((self._since, at, self._state))

    def weigh(self, at: int, charge: float, share: float) -> None:
        """Record the charge of its battery."""
        if self.charge is not None:
            change = charge - self.charge
            self.used, self.charged = self.used + max(0.0, -change), self.charged + max(0.0, change)
        self.charge = charge
        self.measure(at, share)

    def measure(self, at: int, share: float) -> None:
        """Record the remaining share of its battery."""
        if not self.curve or self.curve[-1] != (at, share):
            self.curve.append((at, share))
