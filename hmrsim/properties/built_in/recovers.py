"""The controller does not give up its mission needlessly, after faults that are transient.

Off by default: a controller may report a failure by design. It has to bear a single fault that hits one goal or is
soon over; after several faults it has to succeed if all have been over for some time when it gives up.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.events.faults import FaultBegan, FaultEnded
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.properties.watcher import Watcher

if TYPE_CHECKING:
    from hmrsim.properties.observing.timeline import Timeline
    from hmrsim.properties.results import Ended, Tell, Verdict


class Recovers(Watcher):
    """Follows faults, and knows how the run has ended.

    Args:
        within: How long a single fault may last that has to be borne, and after which time since the last fault the
            mission has to succeed, in simulated seconds.
    """

    def __init__(self, within: float, timeline: Timeline, tell: Tell) -> None:
        super().__init__("recovers", tell)
        self._within = round(within * NANOSECONDS)
        self._active: dict[str, FaultBegan] = {}
        self._begun: list[FaultBegan] = []
        self._last = 0
        self._excused = "the run is not over"
        timeline.on(FaultBegan, self._begin)
        timeline.on(FaultEnded, self._end)

    def _begin(self, _at: int, event: FaultBegan) -> None:
        self._active[event.name] = event
        self._begun.append(event)

    def _end(self, at: int, event: FaultEnded) -> None:
        self._active.pop(event.name, None)
        self._last = at

    def end(self, at: int, ended: Ended | None) -> None:
        """Tell if the mission has failed although its faults were transient."""
        if ended is None or ended.ending not in {"succeeded", "failed"}:
            self._excused = "the controller has not ended by itself"
            return
        self._excused = ""
        if ended.ending == "succeeded" or not self._begun:
            return
        only = self._begun[0]
        if len(self._begun) == 1 and self._is_short(only):
            text = f"the mission failed after a single transient fault, {only.fault}"
            self.violate(at, "", f"gave up after {only.fault}", text)
        elif not self._active and at - self._last >= self._within:
            seconds = (at - self._last) / NANOSECONDS
            text = f"the mission failed although all faults had been over for {seconds:.1f} s"
            self.violate(at, "", "gave up when all faults were over", text)

    def _is_short(self, fault: FaultBegan) -> bool:
        """Return whether a fault hits one goal, or is over within the time."""
        duration = fault.settings.get("duration")
        if duration is not None:
            return float(duration) * NANOSECONDS <= self._within
        return fault.settings.get("count") == 1

    def unless_violated(self) -> Verdict:
        """Return whether the controller has borne its faults."""
        if self._excused:
            return self._is("undecided", 0.0, self._excused)
        if not self._begun:
            return self._is("never_exercised", 1.0, "there was no fault")
        return self._is("holds", 1.0, "the controller did not give up needlessly")
