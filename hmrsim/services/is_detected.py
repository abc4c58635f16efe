"""Return whether the sensors of a robot detect another robot or an item."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.diagnostics import instead
from hmrsim.facilities import Fixture
from hmrsim.goals.fault_effects import no_connection
from hmrsim.interfaces.geometry_msgs import PoseStamped
from hmrsim.interfaces.hmrsim_msgs import IsDetected
from hmrsim.interfaces.simulation_interfaces import Result
from hmrsim.services import Service
from hmrsim.services._entities import unknown
from hmrsim.services._results import OK, failed
from hmrsim.simulation.detections import sensors_of

if TYPE_CHECKING:
    from hmrsim.robots.robot import Robot
    from hmrsim.simulation.detections import Seen
    from hmrsim.simulation.simulator import Simulator


def _serve(simulator: Simulator, request: IsDetected.Request) -> IsDetected.Response:
    name = request.robot
    robot, entity = simulator.robots.get(name), simulator.roster.find(request.entity)
    if robot is None:
        why_not = failed(f"robot: no robot {name!r}{instead(name, simulator.robots)}", Result.RESULT_NOT_FOUND)
    elif name in simulator.dispatcher.cut_off:
        why_not = failed(f"robot: {no_connection(name)}", Result.RESULT_INCORRECT_STATE)
    elif entity is None:
        why_not = unknown(simulator, request.entity)
    elif isinstance(entity, Fixture):
        why_not = failed(f"entity: {entity.name!r} is a {entity.kind}; sensors see robots and items")
    elif not sensors_of(robot):
        why_not = failed(f"robot: {name} has no sensor, such as a camera", Result.RESULT_FEATURE_UNSUPPORTED)
    else:
        return _answer(robot, simulator.detections.look_for(robot, entity))
    return IsDetected.Response(result=why_not)


def _answer(robot: Robot, seen: Seen | None) -> IsDetected.Response:
    if seen is None:
        return IsDetected.Response(result=OK)
    pose = PoseStamped.model_validate(robot.stamped(robot.estimated(seen.thing.pose)), strict=False)
    return IsDetected.Response(result=OK, detected=True, pose=pose, by=[*seen.by])


SERVICE = Service(
    name="is_detected",
    request=IsDetected.Request,
    response=IsDetected.Response,
    serve=_serve,
    example={"robot": "tester", "entity": "parcel"},
)
