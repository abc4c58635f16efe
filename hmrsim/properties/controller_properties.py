"""Built-in properties of the controller and its goals: it survives and ends, and its goals end and are not futile."""

from __future__ import annotations

import re
from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from pydantic import BaseModel
from pydantic_core import to_json

from hmrsim.events.faults import FaultBegan, FaultEnded
from hmrsim.events.goals import GoalAccepted, SendGoalRejected
from hmrsim.events.simulation import ParticipantDropped
from hmrsim.history.occurrence import Commanded
from hmrsim.history.timeline import GoalSeen
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.interfaces.simulation_interfaces import ResetSimulation
from hmrsim.properties.watcher import Watcher, cut_off
from hmrsim.protocol.goal import Cause, GoalStatus

if TYPE_CHECKING:
    from hmrsim.history.timeline import Timeline
    from hmrsim.properties.results import Ended, OnViolation, Verdict


_DEATHS: Final = {
    "crashed": "the controller crashed",
    "hung": "the controller hung",
    "deadlock": "the controller is in a deadlock",
    "out_of_memory": "the controller ran out of memory",
    "died": "the controller died",
}
_ERROR: Final = re.compile(r"^(GoalRejectedError: \w+|\w+)\b.*?(?:\((?:[^()]*[/\\])?([^()/\\]+:\d+)\))?$", re.DOTALL)
"""The name and place of an exception in a line such as ``KeyError: 'eve' (/x/mission.py:12)``.

The name includes the reason of a rejected goal: a broken robot is another cause than an unknown one.
"""


class ControllerLives(Watcher):
    """The controller does not crash, hang, or run out of memory, and is not dropped from lockstep."""

    def __init__(self, timeline: Timeline, on_violation: OnViolation) -> None:
        super().__init__("controller_lives", on_violation)
        self._end_known = False
        timeline.on(ParticipantDropped, self._on_dropped)

    def _on_dropped(self, at: int, event: ParticipantDropped) -> None:
        why = f": {event.why}" if event.why else ""
        self.violate(at, event.participant, "dropped", f"{event.participant} was dropped from lockstep{why}")

    def end(self, at: int, ended: Ended | None) -> None:
        """Report a controller that did not survive to the end."""
        self._end_known = ended is not None and not cut_off(ended)
        if ended is not None and ended.ending in _DEATHS:
            death = _DEATHS[ended.ending]
            # The cause of a deadlock begins with that word.
            cause = ended.cause.removeprefix(f"{ended.ending}: ")
            text = f"{death}: {cause}" if cause else death
            self.violate(at, "", _reason(ended), text, fatal=True)

    def _unless_violated(self) -> Verdict:
        if not self._end_known:
            return self._is("undecided", 0.0, "it is unknown how the controller ended")
        return self._is("holds", 1.0, "the controller lived to the end")


def _reason(ended: Ended) -> str:
    """Return the ending, with the name and place of an exception but without its message."""
    match = _ERROR.match(ended.cause) if ended.ending == "crashed" else None
    if match is None:
        return ended.ending
    place = f" at {match[2]}" if match[2] else ""
    return f"{ended.ending}: {match[1]}{place}"


class MissionEnds(Watcher):
    """The controller ends before the limit of simulated time."""

    def __init__(self, on_violation: OnViolation) -> None:
        super().__init__("mission_ends", on_violation)
        self._at = 0
        self._ending = ""

    def end(self, at: int, ended: Ended | None) -> None:
        """Report a run that reached its time limit."""
        self._at, self._ending = at, ended.ending if ended else ""
        if self._ending == "timeout":
            self.violate(at, "", "timeout", f"the controller had not ended by {at / NANOSECONDS:g} s")

    def _unless_violated(self) -> Verdict:
        if self._ending in {"", "stopped"}:
            return self._is("undecided", 0.0, "the run was stopped before the controller ended")
        return self._is("holds", 1.0, f"the controller ended after {self._at / NANOSECONDS:.1f} s")


def _described(fault: FaultBegan) -> str:
    """Return a fault in words, such as ``goals_aborted of eve (place, error code -25)``."""
    action, code = fault.settings.get("action"), fault.settings.get("error_code")
    goals = [str(action)] * bool(action) + [f"error code {code}"] * bool(code)
    return f"{fault.fault} of {fault.subject}" + (f" ({', '.join(goals)})" if goals else "")


class Recovers(Watcher):
    """The controller does not give up its mission needlessly after transient faults.

    Giving up is needless after a single fault that hits one goal or is short, and after several faults that have been
    over for some time. Off by default, as a controller may report a failure by design.

    Args:
        within: Simulated seconds: the maximum duration of a short fault, and the minimum time since several faults.
    """

    def __init__(self, within: float, timeline: Timeline, on_violation: OnViolation) -> None:
        super().__init__("recovers", on_violation)
        self._within = round(within * NANOSECONDS)
        self._active: dict[str, FaultBegan] = {}
        self._begun: list[FaultBegan] = []
        self._last_end = 0
        self._excuse = "the run is not over"
        timeline.on(FaultBegan, self._begin)
        timeline.on(FaultEnded, self._end)

    def _begin(self, _at: int, event: FaultBegan) -> None:
        self._active[event.name] = event
        self._begun.append(event)

    def _end(self, at: int, event: FaultEnded) -> None:
        self._active.pop(event.name, None)
        self._last_end = at

    def end(self, at: int, ended: Ended | None) -> None:
        """Report a mission that failed although its faults were transient."""
        if ended is None or ended.ending not in {"succeeded", "failed"}:
            self._excuse = "the controller did not end by itself"
            return
        self._excuse = ""
        if ended.ending == "succeeded" or not self._begun:
            return
        first = self._begun[0]
        if len(self._begun) == 1 and self._is_transient(first):
            text = f"the mission failed after a single transient fault, {_described(first)}"
            self.violate(at, "", f"gave up after {first.fault}", text)
        elif not self._active and at - self._last_end >= self._within:
            seconds = (at - self._last_end) / NANOSECONDS
            text = f"the mission failed although all faults had been over for {seconds:.1f} s"
            self.violate(at, "", "gave up when all faults were over", text)

    def _is_transient(self, fault: FaultBegan) -> bool:
        """Return whether a fault hits one goal or is short."""
        duration = fault.settings.get("duration")
        if duration is not None:
            return float(duration) * NANOSECONDS <= self._within
        return fault.settings.get("count") == 1

    def _unless_violated(self) -> Verdict:
        if self._excuse:
            return self._is("undecided", 0.0, self._excuse)
        if not self._begun:
            return self._is("never_exercised", 1.0, "there was no fault")
        return self._is("holds", 1.0, "the controller did not give up needlessly")


_ACCEPTED, _SUCCEEDED, _ABORTED = int(GoalStatus.ACCEPTED), int(GoalStatus.SUCCEEDED), int(GoalStatus.ABORTED)
_BY_ITSELF: Final = ("succeeded", "failed")
"""How a controller ends that could have waited for its goals."""


class GoalsEnd(Watcher):
    """Each accepted goal gets exactly one terminal status by the end of the run."""

    def __init__(self, timeline: Timeline, on_violation: OnViolation) -> None:
        super().__init__("goals_end", on_violation)
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
            again = "ended twice" if status >= _SUCCEEDED else "goes on after its end"
            self.violate(at, goal.robot, again, text)
            return
        # A goal that is ended with the run was still running.
        if status >= _SUCCEEDED and goal.cause != Cause.ENDED:
            del self._open[key]
            self._ended[key] = status

    def leave(self) -> None:
        """Excuse the running goals of a controller that was killed and can no longer end them."""
        self._left.update(self._open)

    def end(self, at: int, ended: Ended | None) -> None:
        """Report goals that are running although their controller has ended by itself."""
        if ended is None or ended.ending not in _BY_ITSELF:
            self._undecided = len(self._open)
            return
        for (robot, goal_id), (since, action) in self._open.items():
            if (robot, goal_id) in self._left:
                self._undecided += 1
                continue
            text = f"goal {goal_id[:8]} of {robot}/{action}, accepted at {since / NANOSECONDS:.1f} s, never ended"
            self.violate(at, robot, "not ended", text)

    def _unless_violated(self) -> Verdict:
        if self._undecided:
            return self._is("undecided", 0.0, f"{self._undecided} of {self._accepted} goals were under way at the end")
        if not self._accepted:
            return self._is("never_exercised", 1.0, "no goal was accepted")
        return self._is("holds", 1.0, f"{self._accepted} goals have ended once")


_OWN_DOING: Final = frozenset({Cause.PREEMPTED, Cause.CANCELED, Cause.RESET, Cause.ENDED, Cause.DELETED})
_STAMP: Final = "stamp"
_PAUSE: Final = 20_000_000_000
"""Nanoseconds of simulated time between a failure and the next goal that end a row."""
_MANY: Final = 10
"""How many rows within one instant are too many, whatever succeeds in between."""


@dataclass(slots=True)
class _Row:
    """A row of failures of one goal, with the time of the last one."""

    last: int
    count: int = 0
    at_once: int = 0


class NoVainGoals(Watcher):
    """The same goal of the same robot is not rejected or aborted as often in a row as the limit.

    Goals are the same if robot, action and message are equal. Failures that the controller causes itself, for instance
    by preempting its own goal, do not count. The row of failures ends when any goal of the robot succeeds, when a goal
    follows after a pause (the controller may poll whether the robot works again), and when the controller is replaced.
    Many failures within one instant violate the property even if goals succeed in between: such a loop may never end.
    """

    def __init__(self, limit: int, timeline: Timeline, on_violation: OnViolation) -> None:
        super().__init__("no_vain_goals", on_violation)
        self._limit = limit
        self._messages: dict[tuple[str, str], Any] = {}
        self._running: dict[tuple[str, str], tuple[int, Any]] = {}
        self._rows: dict[str, dict[Hashable, _Row]] = {}
        self._most = 0
        self._goals = 0
        timeline.on(GoalSeen, self._goal)
        timeline.on(GoalAccepted, lambda _at, event: self.take_message(event.robot, event.action, event.goal))
        timeline.on(Commanded, lambda _at, command: self._command(command))
        timeline.on(SendGoalRejected, self._reject)
        timeline.on(ParticipantDropped, lambda _at, _event: self.begin_anew())
        # A reset of either scope ends all goals.
        ends = ResetSimulation.Request.SCOPE_STATE | ResetSimulation.Request.SCOPE_TIME
        timeline.on_reset(ends, lambda _at: self.begin_anew())

    def begin_anew(self) -> None:
        """Forget all failures, for instance because another controller has taken over."""
        self._rows.clear()

    def take_message(self, robot: str, action: str, message: BaseModel | Mapping[str, Any] | None) -> None:
        """Remember the message of the next goal of a robot's action."""
        self._messages[robot, action] = message

    def _command(self, command: Commanded) -> None:
        line = command.line or {}
        if line.get("command") == "send_goal":
            self.take_message(str(line.get("robot", "")), str(line.get("action", "")), line.get("goal"))

    def _goal(self, at: int, goal: GoalSeen) -> None:
        status, key = goal.status, (goal.robot, goal.goal_id)
        if status == _ACCEPTED:
            self._goals += 1
            self._running[key] = (at, self._messages.pop((goal.robot, goal.action), None))
        elif status == _SUCCEEDED:
            self._running.pop(key, None)
            self._succeed(goal.robot)
        elif status > _SUCCEEDED:
            since, message = self._running.pop(key, (at, None))
            if status == _ABORTED and goal.cause not in _OWN_DOING:
                self._fail((since, at), goal.robot, goal.action, _content(message), ("aborted", goal.cause))

    def _succeed(self, robot: str) -> None:
        for row in self._rows.get(robot, {}).values():
            row.count = 0

    def _reject(self, at: int, event: SendGoalRejected) -> None:
        self._goals += 1
        message = self._messages.pop((event.robot, event.action), None)
        content: Hashable = event.error_msg if message is None else _content(message)
        self._fail((at, at), event.robot, event.action, content, ("rejected", event.reason))

    def _fail(self, span: tuple[int, int], robot: str, action: str, content: Hashable, how: tuple[str, str]) -> None:
        """Count a failed goal; *span* has the times of its acceptance and failure."""
        since, at = span
        row = self._rows.setdefault(robot, {}).setdefault((action, content), _Row(at))
        row.count = 1 if since - row.last >= _PAUSE else row.count + 1
        row.at_once = row.at_once + 1 if at == row.last else 1
        row.last = at
        self._most = max(self._most, row.count)
        word, cause = how
        hint = ""
        if row.count == self._limit:
            reason = f"{word} {row.count} times in a row"
            hint = f"; a pause of {_PAUSE // NANOSECONDS} s starts a new row"
        elif row.at_once == self._limit * _MANY:
            reason = f"{word} {row.at_once} times within one instant"
        else:
            return
        why = f" (the last time: {cause})" if cause else ""
        self.violate(at, robot, reason, f"the same goal of {robot}/{action} was {reason}{why}{hint}", fatal=True)

    def _unless_violated(self) -> Verdict:
        if not self._goals:
            return self._is("never_exercised", 1.0, "no goal was sent")
        said = f"no goal failed more than {self._most} times in a row" if self._most > 1 else "no goal failed twice"
        return self._is("holds", 1.0 - self._most / self._limit, said)


def _content(message: BaseModel | Mapping[str, Any] | None) -> Hashable:
    """Return a value that is equal for equal messages; of a model only the fields that were set."""
    if isinstance(message, BaseModel):
        message = message.model_dump(mode="json", exclude_unset=True)
    return to_json(_unstamped(message))


def _unstamped(value: Any) -> Any:
    """Return plain values without stamps, which differ between goals that are the same."""
    if isinstance(value, Mapping):
        return {key: _unstamped(each) for key, each in value.items() if key != _STAMP}
    return [_unstamped(each) for each in value] if isinstance(value, (list, tuple)) else value
