"""The base of what looks at conditions at the end of each instant at which one may have changed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.properties.conditions.terms import Term
from hmrsim.properties.watcher import Watcher

if TYPE_CHECKING:
    from pydantic import BaseModel

    from hmrsim.properties.observing.observations import Observations
    from hmrsim.properties.results import Tell


class Settling(Watcher):
    """Looks at the conditions of a property; a subclass says what of them is a violation.

    Args:
        subject: The robot that the property is about; empty for none.

    Attributes:
        observations: The state of the world.
        timeline: The time of the run.
        began: When the run began.
    """

    def __init__(self, name: str, subject: str, observations: Observations, tell: Tell) -> None:
        super().__init__(name, tell)
        self.subject = subject
        self.observations = observations
        self.timeline = observations.timeline
        self.began = 0

    def term(self, condition: BaseModel) -> Term:
        """Return a condition that is looked at."""
        return Term(condition, self.observations, self.mark)

    def mark(self) -> None:
        """Look at the end of this instant."""
        self.timeline.settle(self.settled)

    def begin(self, at: int) -> None:
        """Look at the first instant."""
        self.began = at
        self.mark()

    def settled(self, at: int) -> None:
        """Look at the conditions at the end of an instant."""
        raise NotImplementedError
