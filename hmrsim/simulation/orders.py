"""Orders: items to bring somewhere, as the demand of a world requests, and their progress."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from hmrsim.engine.sim_time import stamp
from hmrsim.interfaces.builtin_interfaces import values_of


class OrderState(StrEnum):
    """The progress of an order; the last two states are final."""

    WAITING = "waiting"
    CARRIED = "carried"
    DELIVERED = "delivered"
    LOST = "lost"

    @property
    def open(self) -> bool:
        """Return whether the order has yet to be served."""
        return self in {OrderState.WAITING, OrderState.CARRIED}


@dataclass(eq=False)
class Order:
    """An order. Times are in simulated seconds.

    Attributes:
        name: A name that is unique in the run.
        demand: The name of the demand that placed it; empty for an order of a client.
        item: The name of the item to bring.
        at: The place of the item when the order was placed.
        to: The place to bring it to.
        placed: When it was placed.
        due: The deadline; None for none.
        robot: The robot that carries the item or has brought it; empty for none.
        picked_up: When the item was first picked up; None if it was not.
        ended: When it was delivered or lost; None while it is open.
        late: Whether it was not delivered by the deadline.
    """

    name: str
    demand: str
    item: str
    at: str
    to: str
    priority: int
    placed: float
    due: float | None
    robot: str = ""
    picked_up: float | None = None
    ended: float | None = None
    state: OrderState = OrderState.WAITING
    late: bool = False

    def as_dict(self) -> dict[str, Any]:
        """Return the order as JSON values."""
        times = {"placed": self.placed, "due": self.due, "picked_up": self.picked_up, "ended": self.ended}
        return {
            "name": self.name,
            "demand": self.demand,
            "item": self.item,
            "at": self.at,
            "to": self.to,
            "priority": self.priority,
            "state": self.state.value,
            "robot": self.robot,
            "late": self.late,
            **{name: None if time is None else values_of(stamp(time)) for name, time in times.items()},
        }


@dataclass
class Totals:
    """The number of orders by outcome.

    Attributes:
        placed: All orders.
        delivered: Those that were delivered, in time or late.
        late: Those that were not delivered by their deadline, even if they were later.
        lost: Those whose item was deleted.
    """

    placed: int = 0
    delivered: int = 0
    late: int = 0
    lost: int = 0
