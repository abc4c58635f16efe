"""Patrols: a robot reaches places again and again."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.properties.observing.timeline import Phase
from hmrsim.properties.patterns.arrivals import Arriving, Rounds

if TYPE_CHECKING:
    from hmrsim.properties.observing.observations import Observations
    from hmrsim.properties.observing.timeline import Alarm
    from hmrsim.properties.patterns.orders import Made
    from hmrsim.properties.results import Tell, Verdict


class Patrolling(Arriving):
    """Each place is reached again in time; or all of them, one after the other, if they are in sequence.

    Args:
        in_sequence: Whether each has to be reached after those before it.
        every: Seconds from the start, or from a round or a visit, to the end of the next one.
    """

    def __init__(
        self,
        name: str,
        subject: str,
        places: Sequence[str],
        order: Made,
        observations: Observations,
        tell: Tell,
        *,
        in_sequence: bool,
        every: float,
    ) -> None:
        super().__init__(name, subject, places, order, observations, tell)
        self._in_sequence, self._every = in_sequence, every
        self._rounds = Rounds(len(places))
        self._waits: dict[int, tuple[int, Alarm]] = {}
        self._visits = [0] * len(places)
        self._longest = 0

    def begin(self, at: int) -> None:
        """Begin to wait for the first round."""
        super().begin(at)
        for i in range(1 if self._in_sequence else len(self.places)):
            self._wait(at, i)

    def arrive(self, at: int, place: int) -> None:
        """Note that a place is reached."""
        self._visits[place] += 1
        if not self._in_sequence:
            self._stop_waiting(at, place)
        elif self._rounds.arrive(place):
            self._stop_waiting(at, 0)
            self._wait(at, 0)

    def leave(self, at: int, place: int) -> None:
        """Note that a place is left, which is to be reached again."""
        if not self._in_sequence:
            self._wait(at, place)

    def _wait(self, at: int, i: int) -> None:
        due = at + round(self._every * NANOSECONDS)
        self._waits[i] = at, self.timeline.alarm(due, Phase.EXPIRY, lambda now: self._expire(now, i))

    def _stop_waiting(self, at: int, i: int) -> None:
        if i in self._waits:
            since, alarm = self._waits.pop(i)
            alarm.cancel()
            self._longest = max(self._longest, at - since)

    def _expire(self, at: int, i: int) -> None:
        missing = self.places[self._rounds.next if self._in_sequence else i]
        reason = f"{missing} not every {self._every:g} s"
        self.violate(at, self.subject, reason, f"{self.subject} did not reach {missing} for {self._every:g} s")
        self._wait(at, i)

    def unless_violated(self) -> Verdict:
        """Return whether all rounds were in time; the robustness is the least share of the time that was left."""
        done = self._rounds.done if self._in_sequence else min(self._visits)
        if not done:
            return self._is("undecided", 0.0, f"{self.subject} had not finished its first round by the end")
        seconds = self._longest / NANOSECONDS
        said = f"{done} rounds of {self.subject}, the longest of {seconds:.1f} s"
        return self._is("holds", 1.0 - seconds / self._every, said)
