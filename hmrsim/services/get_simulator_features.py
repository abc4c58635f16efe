"""Return the features of the simulator."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.interfaces.simulation_interfaces import GetSimulatorFeatures, SimulatorFeatures
from hmrsim.services import Service, registry

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator

_ABOUT = "hmrsim: mission-level simulation of robots and items in a plane; get_spawnables lists what can be spawned"


def _serve(_simulator: Simulator, _request: GetSimulatorFeatures.Request) -> GetSimulatorFeatures.Response:
    features = sorted({feature for service in registry().values() for feature in service.features})
    return GetSimulatorFeatures.Response(features=SimulatorFeatures(features=features, custom_info=_ABOUT))


SERVICE = Service(
    name="get_simulator_features",
    request=GetSimulatorFeatures.Request,
    response=GetSimulatorFeatures.Response,
    serve=_serve,
)
