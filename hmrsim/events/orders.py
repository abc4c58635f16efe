"""Events of orders: requests of the demand to bring an item from one place to another."""

from __future__ import annotations

from typing import Annotated, Final

from pydantic import Field

from hmrsim.events._event import Event, EventGroup, Number, Part, RobotName

_Place = Annotated[str, Field(description="The name of a place, a dock or a waypoint.")]


class OrderEvent(Event, subject=("order",), changes=Part.ORDERS):
    """An event of an order."""

    order: Annotated[str, Field(description="The order's name.")]
    item: Annotated[str, Field(description="The item's name.")]


class OrderPlaced(
    OrderEvent, kind="order_placed", text="is placed: bring {item} from {from} to {to}", sets={"step": "placed"}
):
    """An order is placed, and its item appears."""

    from_: Annotated[_Place, Field(description="The place of the item.")]
    to: Annotated[_Place, Field(description="The destination.")]
    priority: Annotated[int, Field(description="The priority; a greater number comes first.")] = 0
    within: Annotated[Number | None, Field(description="Seconds after which it is late; omitted for never.")] = None
    weight: Annotated[Number, Field(description="The mass of the item, in kg.")] = 0.0
    demand: Annotated[str, Field(description="The demand that places it; omitted if a client does.")] = ""


class OrderPickedUp(OrderEvent, kind="order_picked_up", text="is on its way with {robot}", sets={"step": "picked_up"}):
    """A robot picks up the item of an order."""

    robot: RobotName


class OrderDelivered(
    OrderEvent,
    kind="order_delivered",
    text="is delivered[ by {robot}] after {lead_time} s",
    sets={"step": "delivered"},
):
    """The item of an order has reached its destination."""

    lead_time: Annotated[Number, Field(description="Seconds since the order was placed.")]
    late: Annotated[Number, Field(description="Seconds that it is late; 0 if it is in time.")] = 0.0
    robot: Annotated[str, Field(description="The robot that brought it; omitted if none did.")] = ""


class OrderLate(
    OrderEvent,
    kind="order_late",
    severity="warning",
    text="is late: {item} is not at {to} yet",
    sets={"step": "late"},
):
    """An order is not delivered in time."""

    to: Annotated[_Place, Field(description="The destination of the item.")]


class OrderLost(
    OrderEvent,
    kind="order_lost",
    severity="warning",
    text="can't be served: {item} was deleted",
    sets={"step": "lost"},
):
    """The item of an order was deleted."""


EVENTS: Final = EventGroup("orders", (OrderPlaced, OrderPickedUp, OrderDelivered, OrderLate, OrderLost))
