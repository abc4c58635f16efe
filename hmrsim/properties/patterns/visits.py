"""Visits: a robot reaches places once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.properties.observing.timeline import Phase
from hmrsim.properties.patterns.arrivals import Arriving, Rounds
from hmrsim.properties.watcher import cut_off

if TYPE_CHECKING:
    from hmrsim.properties.observing.observations import Observations
    from hmrsim.properties.patterns.orders import Made
    from hmrsim.properties.results import Ended, Tell, Verdict


class Visiting(Arriving):
    """All places are reached, one after the other if they are in sequence.

    Args:
        in_sequence: Whether each has to be reached after those before it.
        within: Seconds from the start of the run; None for any time.
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
        within: float | None,
    ) -> None:
        super().__init__(name, subject, places, order, observations, tell)
        self._in_sequence, self._within = in_sequence, within
        self._rounds = Rounds(len(places))
        self._left = dict.fromkeys(range(len(places)))
        self._done: int | None = None
        self._over = 0

    def begin(self, at: int) -> None:
        """Begin to wait."""
        super().begin(at)
        if self._within is not None:
            self.timeline.alarm(at + round(self._within * NANOSECONDS), Phase.EXPIRY, self._expire)

    def arrive(self, at: int, place: int) -> None:
        """Note that a place is reached."""
        if self._in_sequence:
            complete = self._rounds.arrive(place)
        else:
            self._left.pop(place, None)
            complete = not self._left
        if complete and self._done is None:
            self._done = at

    def _missing(self) -> str:
        place = self._rounds.next if self._in_sequence else next(iter(self._left))
        return self.places[place]

    def _expire(self, at: int) -> None:
        if self._done is None:
            missing = self._missing()
            reason = f"{missing} not within {self._within:g} s"
            self.violate(at, self.subject, reason, f"{self.subject} did not reach {missing} within {self._within:g} s")

    def end(self, at: int, ended: Ended | None) -> None:
        """Tell of places that were never reached."""
        self._over = at
        if self._done is None and self._within is None and not cut_off(ended):
            missing = self._missing()
            self.violate(at, self.subject, f"{missing} never", f"{self.subject} did not reach {missing} by the end")

    def unless_violated(self) -> Verdict:
        """Return whether all places were reached; the robustness is the share of the time that was left."""
        if self._done is None:
            return self._is("undecided", 0.0, f"{self.subject} had not reached {self._missing()} by the end")
        seconds = (self._done - self.began) / NANOSECONDS
        left = 1.0 if self._within is None else 1.0 - seconds / self._within
        return self._is("holds", left, f"{self.subject} reached all places after {seconds:.1f} s")
