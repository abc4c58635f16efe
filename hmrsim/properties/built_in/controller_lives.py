"""The controller does not crash, hang, or run out of memory."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

from hmrsim.events.simulation import ParticipantDropped
from hmrsim.properties.watcher import Watcher

if TYPE_CHECKING:
    from hmrsim.properties.observing.timeline import Timeline
    from hmrsim.properties.results import Ended, Tell, Verdict

_DEATHS: Final = {
    "crashed": "the controller crashed",
    "hung": "the controller hung",
    "deadlock": "the controller is in a deadlock",
    "out_of_memory": "the controller ran out of memory",
    "died": "the controller died",
}
_ERROR: Final = re.compile(r"^(GoalRejectedError: \w+|\w+)\b.*?(?:\((?:[^()]*[/\\])?([^()/\\]+:\d+)\))?$", re.DOTALL)
"""The name of an exception, and the place that raised it, in a line such as ``KeyError: 'eve' (/x/mission.py:12)``.

Why a goal was rejected is a part of the name: a robot that has broken down is not one that does not exist.
"""


class ControllerLives(Watcher):
    """Knows how the controller has ended."""

    def __init__(self, timeline: Timeline, tell: Tell) -> None:
        super().__init__("controller_lives", tell)
        self._known = False
        timeline.on(ParticipantDropped, self._dropped)

    def _dropped(self, at: int, event: ParticipantDropped) -> None:
        why = f": {event.why}" if event.why else ""
        self.violate(at, event.participant, "dropped", f"{event.participant} was dropped from lockstep{why}")

    def end(self, at: int, ended: Ended | None) -> None:
        """Tell if the controller has not lived to the end."""
        self._known = ended is not None and ended.ending != "stopped"
        if ended is not None and ended.ending in _DEATHS:
            said = _DEATHS[ended.ending]
            text = f"{said}: {ended.cause}" if ended.cause else said
            self.violate(at, "", _reason(ended), text, fatal=True)

    def unless_violated(self) -> Verdict:
        """Return whether the controller lived to the end."""
        if not self._known:
            return self._is("undecided", 0.0, "it is not known how the controller has ended")
        return self._is("holds", 1.0, "the controller lived to the end")


def _reason(ended: Ended) -> str:
    """Return the ending with the kind of error and its place, without its message."""
    match = _ERROR.match(ended.cause) if ended.ending == "crashed" else None
    if match is None:
        return ended.ending
    place = f" at {match[2]}" if match[2] else ""
    return f"{ended.ending}: {match[1]}{place}"
