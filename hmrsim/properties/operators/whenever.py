"""Whenever one thing begins, another one follows."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from typing import TYPE_CHECKING, Any

from hmrsim.events import EventPattern
from hmrsim.properties.conditions.binding import bound, bound_names
from hmrsim.properties.conditions.expressions import prepare
from hmrsim.properties.conditions.wording import describe
from hmrsim.properties.model.part import BOUND
from hmrsim.properties.observing.pulses import watch
from hmrsim.properties.operators.obligations import Obligation, Obligations
from hmrsim.properties.operators.settling import Settling
from hmrsim.properties.watcher import cut_off

if TYPE_CHECKING:
    from pydantic import BaseModel

    from hmrsim.properties.conditions.terms import Term
    from hmrsim.properties.observing.observations import Observations
    from hmrsim.properties.results import Ended, Tell, Verdict

_Fields = Callable[[], dict[str, Any]]


class Whenever(Settling):
    """Each time that a trigger begins to hold, something has to hold then or later.

    Of two events at one instant the second one follows the first. A trigger that is no event alone begins to hold at
    the end of an instant, and what holds or comes at that instant follows it.

    Args:
        words: What has to follow, in words that are the same for each robot.
        within: Seconds; None for any time.
    """

    def __init__(
        self,
        name: str,
        subject: str,
        conditions: tuple[BaseModel, BaseModel],
        words: str,
        observations: Observations,
        tell: Tell,
        *,
        within: float | None = None,
    ) -> None:
        super().__init__(name, subject, observations, tell)
        trigger, self._then = conditions
        self._words, self._within = words, within
        self._trigger_said = describe(trigger)
        self._obligations = Obligations(self.timeline, within, self._expired)
        self._undecided = 0
        self._names = bound_names(self._then)
        self._keys: list[tuple[str, str]] = []
        self._met: dict[Hashable, int] = {}
        self._term: Term | None = None
        self._trigger: Term | None = None
        if isinstance(trigger, EventPattern):
            watch(self.timeline, trigger, self._begin_at_event)
        else:
            self._trigger = self.term(trigger)
        if isinstance(self._then, EventPattern):
            open_, self._keys = _opened(self._then)
            watch(self.timeline, open_, self._meet_at_event)
        elif not self._names:
            self._term = self.term(self._then)
        else:
            prepare(self._then, observations)

    def _begin_at_event(self, at: int, fields: _Fields) -> None:
        said = fields() if self._names or not self.subject else {}
        self._begin(at, said)

    def _begin(self, at: int, fields: Mapping[str, Any]) -> None:
        then = bound(self._then, fields) if self._names else self._then
        subject = self.subject or str(fields.get("robot") or fields.get("order") or "")
        obligation = Obligation(at, subject, describe(then))
        if self._names and not isinstance(then, EventPattern):
            obligation.term = self.term(then)
        self._obligations.add(tuple(_hashable(fields.get(name)) for _, name in self._keys), obligation)
        self.mark()

    def _meet_at_event(self, at: int, fields: _Fields) -> None:
        if self._trigger is None and not self._obligations:
            return
        said = fields() if self._keys else {}
        key = tuple(_hashable(said.get(field)) for field, _ in self._keys)
        if self._trigger is not None:
            self._met[key] = at
            self.mark()
        self._obligations.meet(at, key)

    def settled(self, at: int) -> None:
        """Look for triggers, and for what follows."""
        if self._trigger is not None:
            self._trigger.look()
            if self._trigger.hits:
                self._begin(at, {})
            if self._met.get(()) == at:
                self._obligations.meet(at, ())
        if self._term is not None:
            self._term.look()
            if self._term.holds:
                self._obligations.meet(at, ())
        elif self._names and not self._keys:
            self._obligations.meet_those_that_hold(at)

    def _expired(self, at: int, obligation: Obligation) -> None:
        late = f"not within {self._within:g} s" if self._within else "not at once"
        self.violate(
            at, obligation.subject, f"{late}: {self._words}", f"{self._since(obligation)}, and {late} {obligation.said}"
        )

    def _since(self, obligation: Obligation) -> str:
        return f"{self._trigger_said} at {obligation.since / 1e9:.1f} s"

    def end(self, at: int, ended: Ended | None) -> None:
        """Tell of what has never followed, where it had all the time of the run."""
        for obligation in self._obligations.open:
            if self._within is None and not cut_off(ended):
                said = f"{self._since(obligation)}, and never {obligation.said}"
                self.violate(at, obligation.subject, f"never: {self._words}", said)
            else:
                self._undecided += 1

    def unless_violated(self) -> Verdict:
        """Return whether all has followed; the robustness is the least share of the time that was left."""
        count = self._obligations.count
        if not count:
            return self._is("never_exercised", 1.0, f"it was never so that {self._trigger_said}")
        if self._undecided:
            return self._is("undecided", 0.0, f"{self._undecided} of {count} times it had not followed by the end")
        return self._is("holds", self._obligations.least, f"followed each time, {count} in all")


def _opened(then: EventPattern) -> tuple[EventPattern, list[tuple[str, str]]]:
    """Return a pattern without what the trigger binds, and for each such field that of the trigger."""
    keys, where = list[tuple[str, str]](), dict[str, Any]()
    for field, value in then.where.items():
        if isinstance(value, str) and value.startswith(BOUND):
            keys.append((field, value[1:]))
        else:
            where[field] = value
    update: dict[str, Any] = {"where": where}
    for field in ("robot", "action"):
        value = getattr(then, field)
        if isinstance(value, str) and value.startswith(BOUND):
            keys.append((field, value[1:]))
            update[field] = None
    return then.model_copy(update=update), keys


def _hashable(value: Any) -> Hashable:
    return tuple(value) if isinstance(value, list) else value if isinstance(value, Hashable) else repr(value)
