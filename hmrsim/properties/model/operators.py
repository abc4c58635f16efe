"""Properties by temporal operators: always, never, eventually, sometimes, whenever … then."""

from __future__ import annotations

from hmrsim.properties.model.conditions import Condition
from hmrsim.properties.model.part import Identifier, Part, Seconds


class Always(Part):
    """A condition holds at each instant of the run."""

    always: Condition


class Never(Part):
    """A condition holds at no instant of the run."""

    never: Condition


class Eventually(Part):
    """A condition holds at some instant.

    Attributes:
        within: Simulated seconds from the start of the run; None for any time.
    """

    eventually: Condition
    within: Seconds | None = None


class Sometimes(Part):
    """A condition should hold at some instant of some run: this is never violated, but told if it never does."""

    sometimes: Condition


class Whenever(Part):
    """Each time that a condition begins to hold, another one holds then or later.

    Attributes:
        whenever: The trigger: an event, or a condition that begins to hold.
        then: What has to hold; ``$robot`` stands for the field ``robot`` of the trigger's event, and so on.
        within: Simulated seconds from the trigger; None for any time.
    """

    whenever: Condition
    then: Condition
    within: Seconds | None = None


class Reports(Part):
    """If the controller reports an outcome, a condition holds then.

    Attributes:
        reports: The outcome: ``succeeded`` or ``failed`` as the controller ends, or the label that it gives to
            ``end_run``.
        then: What has to hold at that instant.
    """

    reports: Identifier
    then: Condition
