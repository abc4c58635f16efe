"""Probes: each goal fails once, those of a run without faults first, and then those that came about by a failure.

Most faults show to a controller as a goal that fails. So one that has failed stands for many, and what a controller
does next is tried early: in its recovery each goal fails in turn, and in the recovery from that.
"""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Final

from hmrsim.fault_search.schedules.thing import Thing

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from hmrsim.fault_search.running.outcome import Outcome
    from hmrsim.fault_search.schedules.moment import Moment
    from hmrsim.fault_search.schedules.thing import Schedule
    from hmrsim.fault_search.space.menu import Menu

_DOWN: Final = 5.0
"""Seconds for which a robot breaks down that is to fail a goal."""


class Probes:
    """Schedules in which one goal more fails than in a run that was made; each situation is probed once.

    Args:
        menu: What can happen.
        at_most: How many things a schedule has at most.
    """

    def __init__(self, menu: Menu, at_most: int) -> None:
        self._menu, self._at_most = menu, at_most
        self._waiting: deque[Schedule] = deque()
        self._known: dict[tuple[object, ...], None] = {}

    def add(self, schedule: Schedule, outcome: Outcome, moments: Sequence[Moment]) -> None:
        """Add probes of a run.

        Args:
            schedule: Its schedule.
            outcome: What came of it.
            moments: The moments at which goals are to fail.
        """
        if len(schedule) >= self._at_most:
            return
        for moment in moments:
            if moment.goal != "executing":
                continue
            own = tuple(feature for feature in outcome.features if feature.startswith(f"{moment.robot}/"))
            for thing in self._failing(moment):
                key = (thing.key, own)
                if key not in self._known:
                    self._known[key] = None
                    self._waiting.append((*schedule, thing))

    def next(self) -> Schedule | None:
        """Return the next probe; None if there is none."""
        return self._waiting.popleft() if self._waiting else None

    def _failing(self, moment: Moment) -> Iterator[Thing]:
        """Yield what makes a goal fail, as far as it can happen."""
        subject = {"robot": moment.robot, "when": moment.anchor()}
        aborted = Thing({"type": "goals_aborted", "action": moment.action, "count": 1, **subject})
        down = Thing({"type": "breakdown", "duration": _DOWN, **subject})
        return (thing for thing in (aborted, down) if self._menu.allows(thing))
