"""Orders of the demand: what has to be brought where."""

from __future__ import annotations

from typing import Annotated, Final

from pydantic import Field

from hmrsim.events._event import Event, EventGroup
from hmrsim.events._fields import Number, RobotName
from hmrsim.events._parts import Part

_Place = Annotated[str, Field(description="The name of a place, a dock or a waypoint.")]


class OrderEvent(Event, subject=("order",), changes=Part.ORDERS):
    """Something about an order."""

    order: Annotated[str, Field(description="The order's name.")]
    item: Annotated[str, Field(description="The item's name.")]


class OrderPlaced(
    OrderEvent, kind="order_placed", text="asks for {item}, from {from} to {to}", sets={"step": "placed"}
):
    """An order comes, and its item lies there."""

    from_: Annotated[_Place, Field(description="Where the item is.")]
    to: Annotated[_Place, Field(description="Where it has to be brought.")]
    priority: Annotated[int, Field(description="How much it matters; a greater number comes first.")] = 0
    within: Annotated[Number | None, Field(description="Seconds after which it is late; left out for never.")] = None


class OrderPickedUp(OrderEvent, kind="order_picked_up", text="is on its way with {robot}", sets={"step": "picked_up"}):
    """A robot picks up the item of an order."""

    robot: RobotName


class OrderDelivered(
    OrderEvent,
    kind="order_delivered",
    text="is delivered[ by {robot}] after {lead_time} s",
    sets={"step": "delivered"},
):
    """The item of an order lies where it has to be."""

    lead_time: Annotated[Number, Field(description="Seconds since the order came.")]
    late: Annotated[Number, Field(description="Seconds that it is late; 0 if it is in time.")] = 0.0
    robot: Annotated[str, Field(description="The robot that has brought it; left out if none has.")] = ""


class OrderLate(
    OrderEvent,
    kind="order_late",
    severity="warning",
    text="is late: {item} is not at {to} yet",
    sets={"step": "late"},
):
    """An order is not served in time."""

    to: Annotated[_Place, Field(description="Where the item has to be brought.")]


class OrderLost(
    OrderEvent,
    kind="order_lost",
    severity="warning",
    text="can't be served: {item} was deleted",
    sets={"step": "lost"},
):
    """The item of an order is there no more."""


EVENTS: Final = EventGroup("orders", (OrderPlaced, OrderPickedUp, OrderDelivered, OrderLate, OrderLost))
