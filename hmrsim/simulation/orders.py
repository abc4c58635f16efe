"""Orders: what the demand of a world asks for, and what has become of it."""

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
        name: Unique in its run.
        demand: The name of the demand that it comes from; empty for one of a client.
        item: The name of the item to bring.
        at: Where the item was when the order came.
        to: Where it has to be brought.
        placed: When the order came.
        due: When it is late; None for never.
        robot: The robot that carries the item or has brought it; empty for none.
        picked_up: When the item was picked up the first time; None if it was not.
        ended: When it was delivered, or lost; None while it is open.
        late: Whether it was not delivered when it was due.
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
        """Return it in plain values of JSON."""
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
        placed: All that came.
        delivered: Those that were delivered, in time or late.
        late: Those that were not delivered when they were due, delivered since or not.
        lost: Those whose item was deleted.
    """

    placed: int = 0
    delivered: int = 0
    late: int = 0
    lost: int = 0
