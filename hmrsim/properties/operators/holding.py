"""Always, and never."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Final

from hmrsim.properties.conditions.wording import describe
from hmrsim.properties.model.conditions import RobotCondition
from hmrsim.properties.operators.settling import Settling

if TYPE_CHECKING:
    from pydantic import BaseModel

    from hmrsim.properties.observing.observations import Observations
    from hmrsim.properties.results import Tell, Verdict

_FAR: Final = 9.0
"""Radii of the circle around a place beyond which a robot is far from it."""


class Holding(Settling):
    """A condition holds at each instant, or at none; each time that this ends is a violation.

    Args:
        words: The condition in words that are the same for each robot.
        never: Whether it holds at no instant.
    """

    def __init__(
        self,
        name: str,
        subject: str,
        condition: BaseModel,
        words: str,
        observations: Observations,
        tell: Tell,
        *,
        never: bool = False,
    ) -> None:
        super().__init__(name, subject, observations, tell)
        self._never = never
        self._reason = words if never else f"not: {words}"
        self._said = describe(condition)
        self._term = self.term(condition)
        self._clearance: Callable[[], float] | None = None
        if never and isinstance(condition, RobotCondition) and condition.at is not None and condition.is_ is None:
            self._clearance = partial(observations.positions.clearance, condition.robot, condition.at)
        self._fails = False
        self._least = 1.0

    def settled(self, at: int) -> None:
        """Look whether the condition still holds."""
        self._term.look()
        value = -self._term.value if self._never else self._term.value
        self._least = min(self._least, value)
        failed, self._fails = self._fails, value <= 0.0
        if self._fails and (not failed or (self._never and self._term.hits)):
            self.violate(
                at, self.subject, self._reason, self._said if self._never else f"it is not so that {self._said}"
            )

    def unless_violated(self) -> Verdict:
        """Return that it holds; the robustness is the least one of the condition, or how far a robot stayed away."""
        least = self._least if self._clearance is None else min(self._least, self._clearance() / _FAR)
        return self._is("holds", least, f"{'never' if self._never else 'always'} {self._said}")
