"""Place an order of the demand."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from hmrsim.diagnostics import dotted, instead
from hmrsim.interfaces.hmrsim_msgs import PlaceOrder
from hmrsim.interfaces.simulation_interfaces import Result
from hmrsim.services import Service
from hmrsim.services._orders import message_of
from hmrsim.services._results import OK, failed
from hmrsim.world.model import Demand
from hmrsim.world_checks.explain import explain

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator

_NAME = "order"
"""The kind of orders that were given none."""


def _serve(simulator: Simulator, request: PlaceOrder.Request) -> PlaceOrder.Response:
    world = simulator.world
    for field, place in (("at", request.at), ("to", request.to)):
        known = [*world.points, *world.places, *world.docks]
        if place not in known:
            why = f"{field}: no waypoint, place or dock {place!r}{instead(place, known)}"
            return PlaceOrder.Response(result=failed(why, Result.RESULT_NOT_FOUND))
    default = PlaceOrder.Request()
    fields: dict[str, Any] = {key: value for key, value in request if value != getattr(default, key)}
    values = {"name": _NAME, **fields, "arrives": 1.0}
    try:
        spec = Demand.model_validate(values)
    except ValidationError as error:
        found = explain(error, values, Demand)
        return PlaceOrder.Response(result=failed("; ".join(f"{dotted(each.path)}: {each.message}" for each in found)))
    simulator.watch_orders()
    return PlaceOrder.Response(result=OK, order=message_of(simulator.demand.place(spec, by_client=True)))


SERVICE = Service(
    name="place_order",
    request=PlaceOrder.Request,
    response=PlaceOrder.Response,
    serve=_serve,
    changes_world=True,
    example={"at": "here", "to": "there", "within": 60.0},
)
