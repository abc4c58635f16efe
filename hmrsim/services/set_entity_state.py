"""Set the pose of an entity at once."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.facilities import Fixture
from hmrsim.interfaces.geometry_msgs import Accel, Twist
from hmrsim.interfaces.simulation_interfaces import SetEntityState, SimulatorFeatures
from hmrsim.robots.robot import Robot
from hmrsim.services import Service
from hmrsim.services._entities import BadPose, read_pose, unknown
from hmrsim.services._placing import check, check_room
from hmrsim.services._results import OK, failed

if TYPE_CHECKING:
    from hmrsim.interfaces.simulation_interfaces import Result
    from hmrsim.simulation.simulator import Simulator

_WHY = "moved by set_entity_state"


def _set(simulator: Simulator, request: SetEntityState.Request) -> Result:
    entity, state = simulator.roster.find(request.entity), request.state
    if entity is None:
        return unknown(simulator, request.entity)
    if isinstance(entity, Fixture):
        return failed(f"{request.entity!r} is a {entity.kind}, which is part of the building and stays where it is")
    if state.twist != Twist() or state.acceleration != Accel():
        return failed("a velocity or an acceleration can't be set, only the pose; robots move by their actions alone")
    try:
        pose = read_pose(state.header, state.pose)
        check(simulator.graph, pose.point, robot=isinstance(entity, Robot))
        if isinstance(entity, Robot):
            check_room(simulator, pose.point, entity.base, entity.name)
    except BadPose as error:
        return failed(str(error), SetEntityState.Response.INVALID_POSE)
    simulator.roster.move(entity, pose, _WHY)
    return OK


SERVICE = Service(
    name="set_entity_state",
    request=SetEntityState.Request,
    response=SetEntityState.Response,
    serve=lambda simulator, request: SetEntityState.Response(result=_set(simulator, request)),
    changes_world=True,
    features=(SimulatorFeatures.ENTITY_STATE_SETTING,),
    example={"entity": "tester", "state": {"pose": {"position": {"x": 3.0}}}},
)
