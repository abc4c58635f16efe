"""Reactions: what follows a stimulus, and when.

They are looked at at each instant at which one of the two conditions may have changed.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.properties.conditions.wording import describe
from hmrsim.properties.observing.timeline import Phase
from hmrsim.properties.operators.settling import Settling
from hmrsim.properties.watcher import cut_off

if TYPE_CHECKING:
    from pydantic import BaseModel

    from hmrsim.properties.observing.observations import Observations
    from hmrsim.properties.observing.timeline import Alarm
    from hmrsim.properties.results import Ended, Tell, Verdict


class Reacting(Settling):
    """The base: a subclass says which pairs of values are wrong.

    Args:
        conditions: The stimulus, and the reaction.
        words: Both in words that are the same for each robot.
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
        self.words = words
        self.said = [describe(condition) for condition in conditions]
        self._stimulus, self._reaction = (self.term(condition) for condition in conditions)
        self.stimuli = 0

    def settled(self, at: int) -> None:
        """Look at both conditions."""
        self._stimulus.look()
        self._reaction.look()
        self.stimuli += self._stimulus.hits
        self.look(at, self._stimulus.holds, self._reaction.holds)

    def look(self, at: int, stimulus: bool, reaction: bool) -> None:  # noqa: FBT001 - the two values of a letter
        """Look at the values of both at an instant."""
        raise NotImplementedError

    def unless_violated(self) -> Verdict:
        """Return whether there was a stimulus at all."""
        if not self.stimuli:
            return self._is("never_exercised", 1.0, f"it was never so that {self.said[0]}")
        return self._is("holds", 1.0, f"{self.stimuli} times {self.said[0]}")


class Instantaneous(Reacting):
    """G (p1 -> p2)."""

    def look(self, at: int, stimulus: bool, reaction: bool) -> None:  # noqa: FBT001
        """Look whether there is a stimulus without a reaction."""
        if stimulus and not reaction:
            self.violate(
                at, self.subject, f"not at once: {self.words[1]}", f"{self.said[0]}, and not at once {self.said[1]}"
            )


class Bound(Reacting):
    """G (p1 <-> p2)."""

    def look(self, at: int, stimulus: bool, reaction: bool) -> None:  # noqa: FBT001
        """Look whether there is one without the other."""
        if stimulus and not reaction:
            self.violate(
                at, self.subject, f"not at once: {self.words[1]}", f"{self.said[0]}, and not at once {self.said[1]}"
            )
        elif reaction and not stimulus:
            self.violate(at, self.subject, f"without cause: {self.words[1]}", f"{self.said[1]}, and not {self.said[0]}")


class Prompt(Reacting):
    """G (p1 -> X p2): the reaction holds at the next instant."""

    _before: bool | None = None

    def look(self, at: int, stimulus: bool, reaction: bool) -> None:  # noqa: FBT001
        """Look whether the last stimulus is followed by a reaction."""
        if self._before and not reaction:
            self.violate(at, self.subject, f"not next: {self.words[1]}", f"{self.said[0]}, and not next {self.said[1]}")
        self._before = stimulus

    def unless_violated(self) -> Verdict:
        """Return whether there was a stimulus that was followed by another instant."""
        if self._before and self.stimuli == 1:
            return self._is("undecided", 0.0, f"nothing has followed since {self.said[0]}")
        return super().unless_violated()


class BoundLater(Prompt):
    """G (p1 <-> X p2): likewise, and only then."""

    def look(self, at: int, stimulus: bool, reaction: bool) -> None:  # noqa: FBT001
        """Look whether the reaction follows a stimulus, and only one."""
        if self._before is False and reaction:
            text = f"{self.said[1]}, and not before {self.said[0]}"
            self.violate(at, self.subject, f"without cause: {self.words[1]}", text)
        super().look(at, stimulus, reaction)


class Delayed(Reacting):
    """G (p1 -> F p2): the reaction holds then or later.

    Args:
        within: Seconds; None for any time.
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
        within: float | None,
    ) -> None:
        super().__init__(name, subject, conditions, words, observations, tell)
        self._within = within
        self._since: int | None = None
        self._alarm: Alarm | None = None
        self._least = 1.0
        self._undecided = False

    def look(self, at: int, stimulus: bool, reaction: bool) -> None:  # noqa: FBT001
        """Look whether a reaction is due, or has come."""
        if reaction:
            if self._since is not None and self._within is not None:
                self._least = min(self._least, 1.0 - (at - self._since) / NANOSECONDS / self._within)
            self._stop()
        elif stimulus and self._since is None:
            self._since = at
            if self._within is not None:
                self._alarm = self.timeline.alarm(at + round(self._within * NANOSECONDS), Phase.EXPIRY, self._expire)

    def _stop(self) -> None:
        if self._alarm is not None:
            self._alarm.cancel()
        self._since = self._alarm = None

    def _expire(self, at: int) -> None:
        reason = f"not within {self._within:g} s: {self.words[1]}"
        self.violate(at, self.subject, reason, f"{self.said[0]}, and not within {self._within:g} s {self.said[1]}")
        self._stop()

    def end(self, at: int, ended: Ended | None) -> None:
        """Tell if a reaction has never come."""
        if self._since is None:
            return
        if self._within is None and not cut_off(ended):
            self.violate(at, self.subject, f"never: {self.words[1]}", f"{self.said[0]}, and never {self.said[1]}")
        else:
            self._undecided = True

    def unless_violated(self) -> Verdict:
        """Return whether all reactions have come; the robustness is the least share of the time that was left."""
        if self._undecided:
            return self._is("undecided", 0.0, f"it was not so by the end that {self.said[1]}")
        verdict = super().unless_violated()
        return verdict._replace(robustness=self._least) if verdict.state == "holds" else verdict
