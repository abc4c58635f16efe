"""The event after which a fault begins, instead of at a time."""

from __future__ import annotations

from typing import Annotated

from pydantic import ConfigDict, Field

from hmrsim.events import EventPattern

_MAX = 1e9

Seconds = Annotated[float, Field(strict=True, ge=0, le=_MAX, json_schema_extra={"unit": "s"})]


class Anchor(EventPattern):
    """The event a fault waits for: an event with values of its fields, or a change of a goal.

    Attributes:
        event: A kind of event, such as ``picked``.
        where: Values of its fields, as its JSON has them; all must be equal.
        goal: The change of a goal; ``ended`` stands for succeeded, canceled and aborted.
        action: The action of that goal; omitted for any.
        robot: The robot of the event or goal; omitted for any.
        nth: The number of the matching event, from 1, since the start of the run, a reset or the fault's injection.
        after: Simulated seconds from the event to the fault; with 0 the fault begins later in the same instant.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True, allow_inf_nan=False)

    nth: Annotated[int, Field(strict=True, ge=1)] = 1
    after: Seconds = 0.0

    def describe(self) -> str:
        """Return the anchor in words, such as ``0.5 s after pickup of eve is executing (number 2)``."""
        delay = f"{self.after:g} s after " if self.after else ""
        return f"{delay}{super().describe()}{f' (number {self.nth})' if self.nth > 1 else ''}"
