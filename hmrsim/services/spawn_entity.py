"""Spawn a robot or an item."""

from __future__ import annotations

import re
from itertools import count
from typing import TYPE_CHECKING, Final

from hmrsim.interfaces.simulation_interfaces import Result, SimulatorFeatures, SpawnEntity
from hmrsim.services import Service
from hmrsim.services._entities import BadPose, read_pose
from hmrsim.services._placing import check, check_room
from hmrsim.services._results import OK, RequestFailed, failed
from hmrsim.services._spawnables import LIKE, ROBOT, Kind, kinds
from hmrsim.world.model import ROS_NAME, RobotSpec

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator

_MAX_NAME: Final = 100
_Response = SpawnEntity.Response


def _serve(simulator: Simulator, request: SpawnEntity.Request) -> SpawnEntity.Response:
    try:
        kind = _kind(simulator, request)
        name = _name(simulator, request, kind)
        asked = request.initial_pose
        pose = read_pose(asked.header, asked.pose)
        check(simulator.graph, pose.point, robot=kind.robot_type is not None)
        if kind.robot_type is not None:
            spec = RobotSpec(type=kind.robot_type, at=pose.point)
            check_room(simulator, pose.point, simulator.world.robot_type(spec).base)
    except RequestFailed as error:
        return _Response(result=failed(str(error), error.code))
    except BadPose as error:
        return _Response(result=failed(str(error), _Response.INVALID_POSE))
    if kind.robot_type is not None:
        simulator.roster.spawn_robot(name, kind.robot_type, pose)
    else:
        simulator.roster.spawn_item(name, kind.weight, pose.point)
    return _Response(result=OK, entity_name=name)


def _kind(simulator: Simulator, request: SpawnEntity.Request) -> Kind:
    """Return the spawnable that is requested.

    Raises:
        RequestFailed: Nothing that there is.
    """
    if request.entity_namespace:
        message = "entities have no namespace here: their name is one; leave it empty"
        raise RequestFailed(message, _Response.NAMESPACE_INVALID)
    there = {kind.uri: kind for kind in kinds(simulator.world)}
    known = f"there are: {', '.join(there)}"
    if not request.uri:
        if request.resource_string:
            raise RequestFailed(
                f"a resource_string can't be spawned, only a uri; {known}", _Response.UNSUPPORTED_FORMAT
            )
        raise RequestFailed(f"neither uri nor resource_string is given; {known}", _Response.NO_RESOURCE)
    if request.uri not in there:
        ours = request.uri.startswith((ROBOT, LIKE))
        code = Result.RESULT_NOT_FOUND if ours else _Response.UNSUPPORTED_FORMAT
        raise RequestFailed(f"nothing to spawn of uri {request.uri[:200]!r}; {known}", code)
    return there[request.uri]


def _name(simulator: Simulator, request: SpawnEntity.Request, kind: Kind) -> str:
    """Return the name to give.

    Raises:
        RequestFailed: It is invalid, or another entity has it, and the request does not allow renaming.
    """
    name = request.name
    if not name and not request.allow_renaming:
        raise RequestFailed("the name is empty; give one, or allow_renaming", _Response.NAME_INVALID)
    if name and not (re.fullmatch(ROS_NAME, name, re.ASCII) and len(name) <= _MAX_NAME):
        message = (
            f"{name[:_MAX_NAME]!r} is not a name: expected up to {_MAX_NAME} letters, digits and _, a letter first"
        )
        raise RequestFailed(message, _Response.NAME_INVALID)
    if name and simulator.roster.find(name) is None:
        return name
    if not request.allow_renaming:
        message = f"there is an entity {name!r} already; give another name, or allow_renaming"
        raise RequestFailed(message, _Response.NAME_NOT_UNIQUE)
    stem = name or re.sub(r"^[^A-Za-z]+|\W", "", kind.stem, flags=re.ASCII) or "entity"
    made = (f"{stem[: _MAX_NAME - len(str(number)) - 1]}_{number}" for number in count(1))
    return next(name for name in made if simulator.roster.find(name) is None)


SERVICE = Service(
    name="spawn_entity",
    request=SpawnEntity.Request,
    response=SpawnEntity.Response,
    serve=_serve,
    changes_world=True,
    features=(SimulatorFeatures.SPAWNING,),
    example={"name": "helper", "uri": "robot_type:fetcher", "initial_pose": {"pose": {"position": {"x": 4.0}}}},
)
