"""Return the orders of the demand."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from hmrsim.diagnostics import instead, shown
from hmrsim.interfaces.hmrsim_msgs import GetOrders
from hmrsim.services import Service
from hmrsim.services._orders import message_of
from hmrsim.services._results import OK, failed
from hmrsim.simulation.orders import OrderState

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator

_OPEN: Final = "open"


def _serve(simulator: Simulator, request: GetOrders.Request) -> GetOrders.Response:
    demand = simulator.demand
    states = [_OPEN, *OrderState]
    if request.state and request.state not in states:
        return GetOrders.Response(result=failed(f"no state {shown(request.state)}{instead(request.state, states)}"))
    orders = [*demand.closed, *demand.open.values()]
    orders.sort(key=lambda order: order.placed)
    wanted = [
        message_of(order)
        for order in orders
        if request.state in {"", order.state} or (request.state == _OPEN and order.state.open)
    ]
    totals = demand.totals
    return GetOrders.Response(
        result=OK,
        orders=wanted,
        placed=totals.placed,
        delivered=totals.delivered,
        late=totals.late,
        lost=totals.lost,
    )


SERVICE = Service(
    name="get_orders", request=GetOrders.Request, response=GetOrders.Response, serve=_serve, example={"state": "open"}
)
