"""What orders cost while they are open, by the truth of the world."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from hmrsim.simulation.demand import Demand
    from hmrsim.simulation.orders import Order

LATE: Final = 4.0
"""How much more a minute costs that an order is late."""

_MINUTE: Final = 60.0


class Cost:
    """Counts what open orders cost: each minute its weight, and `LATE` times that in addition while it is late.

    An order's weight is 1 and its priority, if that is more than 0.
    """

    def __init__(self, demand: Demand) -> None:
        self._demand = demand
        self._until = 0.0

    def up_to(self, now: float) -> float:
        """Return what the time since the call before has cost."""
        since, self._until = self._until, now
        if now <= since:
            return 0.0
        cost = sum([_cost(order, since, now) for order in self._demand.open.values()])
        for order in reversed(self._demand.closed):
            if order.ended is None or order.ended <= since:
                break
            cost += _cost(order, since, order.ended)
        return cost


def _cost(order: Order, since: float, until: float) -> float:
    """Return what an order that is open then costs in a span of time."""
    seconds = until - max(since, order.placed)
    if order.due is not None:
        seconds += LATE * max(0.0, until - max(since, order.due))
    return (1.0 + max(order.priority, 0)) * seconds / _MINUTE
