"""Avoidance, and waiting: what must not hold, or must, before or after something else."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from hmrsim.properties.conditions.wording import describe
from hmrsim.properties.operators.settling import Settling
from hmrsim.properties.watcher import cut_off

if TYPE_CHECKING:
    from pydantic import BaseModel

    from hmrsim.properties.observing.observations import Observations
    from hmrsim.properties.results import Ended, Tell, Verdict


class HeldUntil(Settling):
    """A condition holds, or does not, until another one holds: (not l1) U p, or l1 U p.

    Args:
        conditions: The first one, and the other one.
        words: Both in words that are the same for each robot.
        avoided: Whether the first one must not hold.
    """

    def __init__(
        self,
        name: str,
        subject: str,
        conditions: tuple[BaseModel, BaseModel],
        words: tuple[str, str],
        observations: Observations,
        tell: Tell,
        *,
        avoided: bool,
    ) -> None:
        super().__init__(name, subject, observations, tell)
        self._words, self._avoided = words, avoided
        self._said = [describe(condition) for condition in conditions]
        self._term, self._until = (self.term(condition) for condition in conditions)
        self._over = False

    def settled(self, at: int) -> None:
        """Look whether the other one has come, and at the first one until then."""
        if self._over or self.first:
            return
        self._term.look()
        self._until.look()
        self._over = self._until.holds
        if not self._over and self._term.holds is self._avoided:
            word = "before" if self._avoided else "no longer, before"
            self.violate(
                at, self.subject, f"{self._words[0]} {word} {self._words[1]}", f"{self._said[0]} {word} {self._said[1]}"
            )

    def end(self, at: int, ended: Ended | None) -> None:
        """Tell if the other one has never come."""
        if not (self._over or self.first or cut_off(ended)):
            self.violate(at, self.subject, f"never: {self._words[1]}", f"it was never so that {self._said[1]}")

    def unless_violated(self) -> Verdict:
        """Return whether the other one has come."""
        if not self._over:
            return self._is("undecided", 0.0, f"it was not so by the end that {self._said[1]}")
        return self._is(
            "holds", 1.0, f"until {self._said[1]} it was {'not ' if self._avoided else ''}so that {self._said[0]}"
        )


class AvoidedAfter(Settling):
    """A condition does not hold any more once another one has held: G (c -> G not l1).

    Args:
        conditions: The one that is avoided, and the one after which it is.
    """

    def __init__(
        self,
        name: str,
        subject: str,
        conditions: tuple[BaseModel, BaseModel],
        words: tuple[str, str],
        observations: Observations,
        tell: Tell,
    ) -> None:
        super().__init__(name, subject, observations, tell)
        self._words = words
        self._said = [describe(condition) for condition in conditions]
        self._term, self._after = (self.term(condition) for condition in conditions)
        self._since = False
        self._held = False

    def settled(self, at: int) -> None:
        """Look whether the other one has held, and at the first one from then on."""
        self._term.look()
        self._after.look()
        self._since = self._since or self._after.holds
        held, self._held = self._held, self._since and self._term.holds
        if self._held and (not held or self._term.hits):
            text = f"{self._said[0]} after {self._said[1]}"
            self.violate(at, self.subject, f"{self._words[0]} after {self._words[1]}", text)

    def unless_violated(self) -> Verdict:
        """Return whether the other one has held at all."""
        if not self._since:
            return self._is("never_exercised", 1.0, f"it was never so that {self._said[1]}")
        return self._is("holds", 1.0, f"since {self._said[1]} it was not so that {self._said[0]}")


class Counted(Settling):
    """A condition begins to hold so many times at least, and so many times at most."""

    def __init__(
        self,
        name: str,
        subject: str,
        condition: BaseModel,
        words: str,
        observations: Observations,
        tell: Tell,
        *,
        least: int = 0,
        most: float = math.inf,
    ) -> None:
        super().__init__(name, subject, observations, tell)
        self._words, self._said = words, describe(condition)
        self._least, self._most = least, most
        self._term = self.term(condition)
        self._times = 0

    def settled(self, at: int) -> None:
        """Count how often it begins to hold."""
        self._term.look()
        before, self._times = self._times, self._times + self._term.hits
        if before <= self._most < self._times:
            text = f"it is so for the {self._times}. time that {self._said}"
            self.violate(at, self.subject, f"more than {self._most:g} times: {self._words}", text)

    def end(self, at: int, ended: Ended | None) -> None:
        """Tell if it has not happened often enough."""
        if self._times < self._least and not cut_off(ended):
            text = f"it was so {self._times} times, and not {self._least} times, that {self._said}"
            self.violate(at, self.subject, f"less than {self._least} times: {self._words}", text)

    def unless_violated(self) -> Verdict:
        """Return how often it was."""
        said = f"it was so {self._times} times that {self._said}"
        if self._times < self._least:
            return self._is("undecided", 0.0, said)
        room = 1.0 if math.isinf(self._most) else (self._most - self._times) / self._most
        return self._is("holds", room if self._least != self._most else 1.0, said)
