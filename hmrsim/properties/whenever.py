"""Properties about each trigger: whenever it begins, something follows."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from typing import TYPE_CHECKING, Any

from hmrsim.events import EventPattern
from hmrsim.properties.model.part import BOUND, bound, bound_names
from hmrsim.properties.observing.pulses import watch
from hmrsim.properties.operators import Instance, Temporal
from hmrsim.properties.terms import Term, prepare
from hmrsim.properties.watcher import Obligation, Obligations, cut_off

if TYPE_CHECKING:
    from hmrsim.properties.model.conditions import Condition
    from hmrsim.properties.results import Ended, Verdict

_Fields = Callable[[], dict[str, Any]]


class Whenever(Temporal):
    """Each time that a trigger begins to hold, something has to hold then or later.

    Of two events at one instant the second one follows the first. A trigger that is not an event begins to hold at the
    end of an instant, and everything that holds or comes at that instant follows it.

    Args:
        trigger: The field with the trigger.
        within: Seconds; None for any time.
    """

    def __init__(self, of: Instance, trigger: str, within: float | None) -> None:
        self._then: Condition = of.part.then
        condition = getattr(of.part, trigger)
        self._names = bound_names(self._then)
        by_event, event_follows = isinstance(condition, EventPattern), isinstance(self._then, EventPattern)
        fields = [*([] if by_event else [trigger]), *([] if event_follows or self._names else ["then"])]
        super().__init__(of, *fields)
        self._trigger = None if by_event else self.terms[0]
        self._term = self.terms[-1] if "then" in fields else None
        self._words, self._within = of.template.then.describe(), within
        self._trigger_text = condition.describe()
        self._obligations: Obligations[tuple[Hashable, ...]] = Obligations(self.timeline, within, self._expired)
        self._undecided = 0
        self._keys: list[tuple[str, str]] = []
        self._met: dict[Hashable, int] = {}
        if isinstance(condition, EventPattern):
            watch(self.timeline, condition, self._begin_at_event)
        if isinstance(self._then, EventPattern):
            pattern, self._keys = _opened(self._then)
            watch(self.timeline, pattern, self._meet_at_event)
        elif self._names:
            prepare(self._then, of.observations)

    def _begin_at_event(self, at: int, fields: _Fields) -> None:
        self._begin(at, fields() if self._names or not self.subject else {})

    def _begin(self, at: int, fields: Mapping[str, Any]) -> None:
        then = bound(self._then, fields) if self._names else self._then
        subject = self.subject or str(fields.get("robot") or fields.get("order") or "")
        key = tuple(_hashable(fields.get(name)) for _, name in self._keys)
        obligation = Obligation(at, key, subject, then.describe())
        if self._names and not isinstance(then, EventPattern):
            obligation.term = Term(then, self.observations, self.mark)
        self._obligations.add(obligation)
        self.mark()

    def _meet_at_event(self, at: int, fields: _Fields) -> None:
        if self._trigger is None and not self._obligations:
            return
        values = fields() if self._keys else {}
        key = tuple(_hashable(values.get(field)) for field, _ in self._keys)
        if self._trigger is not None:
            self._met[key] = at
            self.mark()
        self._obligations.meet(at, key)

    def step(self, at: int) -> None:
        """Check whether the trigger begins, and which obligations are met."""
        if self._trigger is not None:
            if self._trigger.hits:
                self._begin(at, {})
            if self._met.get(()) == at:
                self._obligations.meet(at, ())
        if self._term is not None:
            if self._term.holds:
                self._obligations.meet(at, ())
        elif self._names and not self._keys:
            self._obligations.meet_terms(at)

    def _expired(self, at: int, obligation: Obligation[tuple[Hashable, ...]]) -> None:
        late = f"not within {self._within:g} s" if self._within else "not at once"
        text = f"{self._since(obligation)}, and {late} {obligation.text}"
        self.violate(at, obligation.subject, f"{late}: {self._words}", text)

    def _since(self, obligation: Obligation[tuple[Hashable, ...]]) -> str:
        return f"{self._trigger_text} at {obligation.since / 1e9:.1f} s"

    def end(self, at: int, ended: Ended | None) -> None:
        """Report each trigger that nothing has followed, if it had all the time of the run."""
        for obligation in self._obligations.open:
            if self._within is None and not cut_off(ended):
                text = f"{self._since(obligation)}, and never {obligation.text}"
                self.violate(at, obligation.subject, f"never: {self._words}", text)
            else:
                self._undecided += 1

    def unless_violated(self) -> Verdict:
        """Return whether each trigger was followed; the robustness is the least share of the time that was left."""
        count = self._obligations.count
        if not count:
            return self._is("never_exercised", 1.0, f"it was never so that {self._trigger_text}")
        if self._undecided:
            return self._is("undecided", 0.0, f"{self._undecided} of {count} times it had not followed by the end")
        return self._is("holds", self._obligations.least, f"followed each time, {count} in all")


def _opened(then: EventPattern) -> tuple[EventPattern, list[tuple[str, str]]]:
    """Return a pattern without its bound fields, and for each of them that of the trigger."""
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
