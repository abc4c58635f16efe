"""Terms: conditions that tell when they begin to hold."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from hmrsim.events import EventPattern
from hmrsim.properties.conditions.expressions import Expression
from hmrsim.properties.observing.pulses import watch
from hmrsim.properties.observing.signal import FAILS, HOLDS

if TYPE_CHECKING:
    from pydantic import BaseModel

    from hmrsim.properties.observing.observations import Observations


class Term:
    """A condition of a property, which is looked at when an instant is settled at which it may have changed.

    An event alone holds at its instant, and each event counts; anything else counts when it begins to hold.

    Args:
        changed: Called when it may have changed.

    Attributes:
        value: The robustness when it was last looked at.
        hits: How often it has begun to hold since it was looked at before.
    """

    def __init__(self, condition: BaseModel, observations: Observations, changed: Callable[[], object]) -> None:
        self.value = FAILS
        self.hits = 0
        self._came = 0
        self._changed = changed
        self._expression: Expression | None = None
        if isinstance(condition, EventPattern):
            watch(observations.timeline, condition, self._come)
        else:
            self._expression = Expression(condition, observations)
            for signal in self._expression.signals:
                signal.tell(changed)

    @property
    def holds(self) -> bool:
        """Whether it held when it was last looked at."""
        return self.value > 0.0

    def look(self) -> None:
        """Look at it again."""
        if self._expression is None:
            self.hits, self._came = self._came, 0
            self.value = HOLDS if self.hits else FAILS
        else:
            held, self.value = self.value > 0.0, self._expression.value()
            self.hits = int(self.value > 0.0 and not held)

    def close(self) -> None:
        """Look at nothing any more."""
        for signal in self._expression.signals if self._expression else ():
            signal.forget(self._changed)

    def _come(self, _at: int, _fields: Callable[[], dict[str, Any]]) -> None:
        self._came += 1
        self._changed()
