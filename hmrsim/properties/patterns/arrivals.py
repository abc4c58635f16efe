"""The base of patterns of the places that a robot reaches."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from hmrsim.properties.model.conditions import RobotCondition
from hmrsim.properties.operators.settling import Settling

if TYPE_CHECKING:
    from hmrsim.properties.observing.observations import Observations
    from hmrsim.properties.patterns.orders import Made
    from hmrsim.properties.results import Tell


class Arriving(Settling):
    """Notes when a robot reaches places; of those that it reaches at one instant the earlier ones in the list first.

    Args:
        subject: The robot.
        places: Their names.
        order: Makes the order in which they may be reached.
    """

    def __init__(
        self, name: str, subject: str, places: Sequence[str], order: Made, observations: Observations, tell: Tell
    ) -> None:
        super().__init__(name, subject, observations, tell)
        self.places = places
        self._order = order(len(places))
        self._terms = [self.term(RobotCondition(robot=subject, at=place)) for place in places]

    def settled(self, at: int) -> None:
        """Note which places are reached, and left."""
        for i, term in enumerate(self._terms):
            held = term.holds
            term.look()
            if term.hits:
                wrong = self._order.arrive(i)
                if wrong:
                    text = f"{self.subject} reaches {self.places[i]} {wrong}"
                    self.violate(at, self.subject, f"{self.places[i]} {wrong}", text)
                self.arrive(at, i)
            elif held and not term.holds:
                self.leave(at, i)

    def arrive(self, at: int, place: int) -> None:
        """Note that a place is reached."""
        raise NotImplementedError

    def leave(self, at: int, place: int) -> None:
        """Note that a place is left."""


class Rounds:
    """Counts how often places were reached one after the other: F (l1 and F (l2 and ...)).

    Attributes:
        done: How often.
        next: The number of the place that is to be reached next.
    """

    def __init__(self, count: int) -> None:
        self._count = count
        self.done = 0
        self.next = 0

    def arrive(self, place: int) -> bool:
        """Take note of an arrival; return whether the sequence is complete."""
        if place != self.next:
            return False
        self.next += 1
        if self.next < self._count:
            return False
        self.done, self.next = self.done + 1, 0
        return True
