"""The lift is out of order: it completes its ride and then stops; robots take other routes."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, cast

from hmrsim.faults import Case, FaultType, Name, Spell

if TYPE_CHECKING:
    from hmrsim.facilities.lifts import Lift


class LiftOutOfOrder(Spell):
    """The outage of a lift.

    Attributes:
        lift: The lift's name.
    """

    lift: Name


def _begin(case: Case[LiftOutOfOrder]) -> Callable[[], None]:
    lift = cast("Lift", case.roster.fixtures[case.settings.lift])
    lift.fail()
    return lift.repair


FAULT = FaultType(
    name="lift_out_of_order", settings=LiftOutOfOrder, begin=_begin, example={"lift": "lift"}, title="Out of order"
)
