"""Each accepted goal gets exactly one terminal status by the end of the run."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.properties.observing.timeline import GoalSeen
from hmrsim.properties.watcher import Watcher
from hmrsim.protocol.goal import Cause, GoalStatus

if TYPE_CHECKING:
    from hmrsim.properties.observing.timeline import Timeline
    from hmrsim.properties.results import Ended, Tell, Verdict

_BY_ITSELF: Final = ("succeeded", "failed")
"""Endings of a controller that could have waited for its goals."""

_TERMINAL: Final = int(GoalStatus.SUCCEEDED)
_ACCEPTED: Final = int(GoalStatus.ACCEPTED)


class GoalsEnd(Watcher):
    """Knows the goals that are under way, and those that have ended."""

    def __init__(self, timeline: Timeline, tell: Tell) -> None:
        super().__init__("goals_end", tell)
        self._open: dict[tuple[str, str], tuple[int, str]] = {}
        self._left: set[tuple[str, str]] = set()
        self._ended: dict[tuple[str, str], int] = {}
        self._accepted = 0
        self._undecided = 0
        timeline.on(GoalSeen, self._goal)

    def _goal(self, at: int, goal: GoalSeen) -> None:
        key, status = (goal.robot, goal.goal_id), goal.status
        if status == _ACCEPTED or (key not in self._open and key not in self._ended):
            self._accepted += 1
            self._ended.pop(key, None)
            self._left.discard(key)
            self._open[key] = at, goal.action
        elif key in self._ended:
            before, now = GoalStatus(self._ended[key]).name, GoalStatus(status).name
            text = f"goal {goal.goal_id[:8]} of {goal.robot}/{goal.action} is {now} after it was {before}"
            again = "ended twice" if status >= _TERMINAL else "goes on after its end"
            self.violate(at, goal.robot, again, text)
            return
        # What ends with the run was still under way.
        if status >= _TERMINAL and goal.cause != Cause.ENDED:
            del self._open[key]
            self._ended[key] = status

    def leave(self) -> None:
        """Take note that the goals that are under way are of a controller that can't end them any more."""
        self._left.update(self._open)

    def end(self, at: int, ended: Ended | None) -> None:
        """Tell of goals that are under way though their controller has ended by itself."""
        if ended is None or ended.ending not in _BY_ITSELF:
            self._undecided = len(self._open)
            return
        for (robot, goal_id), (since, action) in self._open.items():
            if (robot, goal_id) in self._left:
                self._undecided += 1
                continue
            text = f"goal {goal_id[:8]} of {robot}/{action}, accepted at {since / NANOSECONDS:.1f} s, never ended"
            self.violate(at, robot, "not ended", text)

    def unless_violated(self) -> Verdict:
        """Return whether all goals have ended."""
        if self._undecided:
            return self._is("undecided", 0.0, f"{self._undecided} of {self._accepted} goals were under way at the end")
        if not self._accepted:
            return self._is("never_exercised", 1.0, "no goal was accepted")
        return self._is("holds", 1.0, f"{self._accepted} goals have ended once")
