"""Participants for which time goes on although they can't ask for it: stalled ones, and those that join later.

Time goes on up to the instant at which the absence ends, and waits for the participant again from there on.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from hmrsim.engine.sim_time import stamp


@dataclass
class _Expected:
    at: float
    on_due: Callable[[], None]
    due: bool = False


class Absences:
    """The absences of participants, by name; times are simulated seconds."""

    def __init__(self) -> None:
        self._stalled: dict[str, float] = {}
        self._expected: dict[str, _Expected] = {}
        self._kept: dict[str, None] = {}

    def __bool__(self) -> bool:
        """Return whether time may go on for the sake of an absence, though nobody asks for it."""
        return bool(self._stalled) or any(not each.due for each in self._expected.values())

    @property
    def due(self) -> float:
        """When the next absence ends; infinite if none does."""
        ends = [*self._stalled.values(), *(each.at for each in self._expected.values() if not each.due)]
        return min(ends, default=math.inf)

    @property
    def awaited(self) -> list[str]:
        """Who is to join now, by name."""
        return sorted(name for name, each in self._expected.items() if each.due)

    def stall(self, name: str, until: float) -> None:
        """Do without a participant until some time, if not for longer."""
        self._stalled[name] = max(until, self._stalled.get(name, until))

    def stalled(self, name: str) -> bool:
        """Return whether time goes on without a participant."""
        return name in self._stalled

    def expect(self, name: str, at: float, on_due: Callable[[], None]) -> None:
        """Expect that somebody joins at some time, which waits for that from then on; *on_due* is called then.

        Args:
            name: Who joins; empty for nobody, so that time goes on from there.
            at: When; infinite for never.
            on_due: Must not change an absence.
        """
        self._expected[name] = _Expected(at, on_due)

    def keep(self, name: str) -> None:
        """Expect a participant again at once whenever it goes."""
        self._kept[name] = None

    def note_gone(self, name: str) -> None:
        """Take note that a participant is gone."""
        self.forget(name)
        if name in self._kept:
            self._expected[name] = _Expected(0.0, lambda: None, due=True)

    def forget(self, name: str) -> None:
        """Take note that a participant is there, or that nobody needs to wait for it."""
        self._stalled.pop(name, None)
        self._expected.pop(name, None)

    def clear(self) -> None:
        """Forget all absences."""
        self._stalled.clear()
        self._expected.clear()
        self._kept.clear()

    def give_up(self) -> None:
        """Let time stand where only those are missing that never come."""
        self._expected = {name: each for name, each in self._expected.items() if each.at < math.inf}

    def end(self, now: float) -> list[str]:
        """End the absences that are over; return who was stalled, in the order of names."""
        over = sorted(name for name, until in self._stalled.items() if stamp(until) <= stamp(now))
        for name in over:
            del self._stalled[name]
        for name, each in sorted(self._expected.items()):
            if not each.due and each.at < math.inf and stamp(each.at) <= stamp(now):
                each.due = True
                each.on_due()
                if not name:
                    del self._expected[name]
        return over

    def shift(self, seconds: float) -> None:
        """Take note that time has gone back by so many seconds: what is left of an absence is left."""
        self._stalled = {name: until - seconds for name, until in self._stalled.items()}
        for each in self._expected.values():
            each.at -= seconds
