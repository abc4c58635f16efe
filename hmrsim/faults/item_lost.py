"""The item is lost: a person took it, or it fell where no robot finds it."""

from __future__ import annotations

from collections.abc import Callable

from hmrsim.faults import Case, FaultType, Name, Occurrence


class ItemLost(Occurrence):
    """The loss of an item.

    Attributes:
        item: The item's name; items of orders are numbered, as in ``medicine_2``.
    """

    item: Name


def _begin(case: Case[ItemLost]) -> Callable[[], None]:
    case.roster.delete(case.settings.item)
    return lambda: None


FAULT = FaultType(name="item_lost", settings=ItemLost, begin=_begin, example={"item": "letter"})
