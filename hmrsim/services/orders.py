"""Services that list and place orders of the demand."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from pydantic import ValidationError

from hmrsim.diagnostics import dotted, instead, shown
from hmrsim.documents.validation import explain
from hmrsim.engine.sim_time import nanoseconds
from hmrsim.interfaces.builtin_interfaces import Time
from hmrsim.interfaces.hmrsim_msgs import GetOrders, PlaceOrder
from hmrsim.interfaces.hmrsim_msgs import Order as OrderMessage
from hmrsim.interfaces.simulation_interfaces import Result
from hmrsim.services import OK, RequestFailed, Service
from hmrsim.simulation.demand import OrderState
from hmrsim.world.model import Demand

if TYPE_CHECKING:
    from hmrsim.simulation.demand import Order
    from hmrsim.simulation.simulator import Simulator


_OPEN: Final = "open"
_DEFAULT_NAME: Final = "order"


def _message_of(order: Order) -> OrderMessage:
    """Return an order as a message; missing times are zero."""
    return OrderMessage(
        name=order.name,
        demand=order.demand,
        item=order.item,
        at=order.at,
        to=order.to,
        priority=order.priority,
        weight=order.weight,
        state=order.state.value,
        robot=order.robot,
        late=order.late,
        placed=_time(order.placed),
        due=_time(order.due),
        picked_up=_time(order.picked_up),
        ended=_time(order.ended),
    )


def _time(seconds: float | None) -> Time:
    return Time.from_nanoseconds(0 if seconds is None else nanoseconds(seconds))


def _get_orders(simulator: Simulator, request: GetOrders.Request) -> GetOrders.Response:
    demand = simulator.demand
    states = [_OPEN, *OrderState]
    if request.state and request.state not in states:
        raise RequestFailed(f"no state {shown(request.state)}{instead(request.state, states)}")
    orders = sorted([*demand.closed, *demand.open.values()], key=lambda order: order.placed)
    requested = [
        _message_of(order)
        for order in orders
        if request.state in {"", order.state} or (request.state == _OPEN and order.state.open)
    ]
    totals = demand.totals
    return GetOrders.Response(
        result=OK,
        orders=requested,
        placed=totals.placed,
        delivered=totals.delivered,
        late=totals.late,
        lost=totals.lost,
    )


def _place_order(simulator: Simulator, request: PlaceOrder.Request) -> PlaceOrder.Response:
    world = simulator.world
    for field, place in (("at", request.at), ("to", request.to)):
        known = [*world.points, *world.places, *world.docks]
        if place not in known:
            raise RequestFailed(
                f"{field}: no waypoint, place or dock {place!r}{instead(place, known)}", Result.RESULT_NOT_FOUND
            )
    default = PlaceOrder.Request()
    fields: dict[str, Any] = {key: value for key, value in request if value != getattr(default, key)}
    values = {"name": _DEFAULT_NAME, **fields, "arrives": 1.0}
    try:
        spec = Demand.model_validate(values)
    except ValidationError as error:
        findings = explain(error, values, Demand)
        raise RequestFailed("; ".join(f"{dotted(finding.path)}: {finding.message}" for finding in findings)) from None
    simulator.watch_orders()
    return PlaceOrder.Response(result=OK, order=_message_of(simulator.demand.place(spec, by_client=True)))


SERVICES = (
    Service(GetOrders, _get_orders, example={"state": "open"}),
    Service(PlaceOrder, _place_order, changes_world=True, example={"at": "here", "to": "there", "within": 60.0}),
)
