"""Properties of the controller: it survives, ends, and does not give up needlessly."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

from hmrsim.events.faults import FaultBegan, FaultEnded
from hmrsim.events.simulation import ParticipantDropped
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.properties.watcher import Watcher, cut_off

if TYPE_CHECKING:
    from hmrsim.history.timeline import Timeline
    from hmrsim.properties.results import Ended, Tell, Verdict

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

    def __init__(self, timeline: Timeline, tell: Tell) -> None:
        super().__init__("controller_lives", tell)
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
            text = f"{death}: {ended.cause}" if ended.cause else death
            self.violate(at, "", _reason(ended), text, fatal=True)

    def unless_violated(self) -> Verdict:
        """Return the verdict: undecided if the end of the controller is unknown."""
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

    def __init__(self, tell: Tell) -> None:
        super().__init__("mission_ends", tell)
        self._at = 0
        self._ending = ""

    def end(self, at: int, ended: Ended | None) -> None:
        """Report a run that reached its time limit."""
        self._at, self._ending = at, ended.ending if ended else ""
        if self._ending == "timeout":
            self.violate(at, "", "timeout", f"the controller had not ended by {at / NANOSECONDS:g} s")

    def unless_violated(self) -> Verdict:
        """Return the verdict: undecided if the run was stopped."""
        if self._ending in {"", "stopped"}:
            return self._is("undecided", 0.0, "the run was stopped before the controller ended")
        return self._is("holds", 1.0, f"the controller ended after {self._at / NANOSECONDS:.1f} s")


class Recovers(Watcher):
    """The controller does not give up its mission needlessly after transient faults.

    Giving up is needless after a single fault that hits one goal or is short, and after several faults that have been
    over for some time. Off by default, as a controller may report a failure by design.

    Args:
        within: Simulated seconds: the maximum duration of a short fault, and the minimum time since several faults.
    """

    def __init__(self, within: float, timeline: Timeline, tell: Tell) -> None:
        super().__init__("recovers", tell)
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
            text = f"the mission failed after a single transient fault, {first.fault}"
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

    def unless_violated(self) -> Verdict:
        """Return the verdict: undecided if the controller did not end by itself."""
        if self._excuse:
            return self._is("undecided", 0.0, self._excuse)
        if not self._begun:
            return self._is("never_exercised", 1.0, "there was no fault")
        return self._is("holds", 1.0, "the controller did not give up needlessly")
