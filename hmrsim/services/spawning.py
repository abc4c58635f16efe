"""Services that list the robots and items that can be spawned, and spawn them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count
from typing import TYPE_CHECKING, Final

from hmrsim.interfaces.simulation_interfaces import (
    GetSpawnables,
    Result,
    SimulatorFeatures,
    Spawnable,
    SpawnEntities,
    SpawnEntity,
    SpawnResult,
)
from hmrsim.services import OK, RequestFailed, Service, failed
from hmrsim.services._entities import BadPose, check_placement, read_pose
from hmrsim.world.model import BUILT_IN_TYPES, ROS_NAME, RobotSpec

if TYPE_CHECKING:
    from hmrsim.geometry import Pose
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.world.model import Base, World

_ITEM: Final = "item"
_ROBOT_TYPE: Final = "robot_type:"
_LIKE: Final = "item:"
_MAX_NAME: Final = 100
_Response = SpawnEntity.Response


@dataclass(frozen=True)
class _Spawnable:
    """A robot type or a kind of item that can be spawned.

    Attributes:
        stem: The prefix of generated names.
        robot_type: The type of a robot; None for an item.
        weight: The weight of an item, in kg.
    """

    uri: str
    description: str
    stem: str
    robot_type: str | None = None
    weight: float = 0.0


def _spawnables(world: World) -> Iterator[_Spawnable]:
    """Yield the spawnables of a world: its robot types, the built-in types, and copies of its items."""
    built_in = {name: kind for name, kind in BUILT_IN_TYPES.items() if name not in world.robot_types}
    for name, kind in (world.robot_types | built_in).items():
        carried = ", ".join(sorted(kind.components)) or "nothing"
        yield _Spawnable(
            f"{_ROBOT_TYPE}{name}", f"robot of type {name}, which carries {carried}", name, robot_type=name
        )
    yield _Spawnable(_ITEM, "item without weight", _ITEM)
    for name, item in world.items.items():
        yield _Spawnable(f"{_LIKE}{name}", f"item like {name}, of {item.weight:g} kg", name, weight=item.weight)


def _get_spawnables(simulator: Simulator, request: GetSpawnables.Request) -> GetSpawnables.Response:
    spawnables = [Spawnable(uri=kind.uri, description=kind.description) for kind in _spawnables(simulator.world)]
    result = OK
    if request.sources:
        why = f"unknown sources are left out: {', '.join(request.sources)}"
        result = Result(result=Result.RESULT_OK, error_message=why)
    return GetSpawnables.Response(result=result, spawnables=spawnables)


def _spawn_entity(simulator: Simulator, request: SpawnEntity.Request) -> SpawnEntity.Response:
    kind = _requested(simulator, request)
    name = _new_name(simulator, request, kind)
    try:
        pose = read_pose(request.initial_pose.header, request.initial_pose.pose)
        check_placement(simulator, pose, _base_of(simulator, kind, pose))
    except BadPose as error:
        raise RequestFailed(str(error), _Response.INVALID_POSE) from None
    if kind.robot_type is not None:
        simulator.roster.spawn_robot(name, kind.robot_type, pose)
    else:
        simulator.roster.spawn_item(name, kind.weight, pose.point)
    return _Response(result=OK, entity_name=name)


def _spawn_entities(simulator: Simulator, request: SpawnEntities.Request) -> SpawnEntities.Response:
    results = []
    for one in request.spawn_requests:
        resource = one.entity_resource
        single = SpawnEntity.Request(
            name=one.name,
            allow_renaming=one.allow_renaming,
            uri=resource.uri,
            resource_string=resource.resource_string,
            entity_namespace=one.entity_namespace,
            initial_pose=one.initial_pose,
        )
        try:
            results.append(SpawnResult(result=OK, entity_name=_spawn_entity(simulator, single).entity_name))
        except RequestFailed as error:
            results.append(SpawnResult(result=error.result))
    flaws = [
        f"spawn_requests.{number}: {one.result.error_message}"
        for number, one in enumerate(results)
        if one.result.result != Result.RESULT_OK
    ]
    code = SpawnEntities.Response.ENTITIES_SPAWN_FAILED
    return SpawnEntities.Response(result=failed("; ".join(flaws), code) if flaws else OK, results=results)


def _base_of(simulator: Simulator, kind: _Spawnable, pose: Pose) -> Base | None:
    if kind.robot_type is None:
        return None
    return simulator.world.robot_type(RobotSpec(type=kind.robot_type, at=pose.point)).base


def _requested(simulator: Simulator, request: SpawnEntity.Request) -> _Spawnable:
    """Return the requested spawnable.

    Raises:
        RequestFailed: It does not exist.
    """
    if request.entity_namespace:
        message = "entities have no namespace here: their name is one; leave it empty"
        raise RequestFailed(message, _Response.NAMESPACE_INVALID)
    spawnables = {kind.uri: kind for kind in _spawnables(simulator.world)}
    known = f"there are: {', '.join(spawnables)}"
    if not request.uri:
        if request.resource_string:
            raise RequestFailed(
                f"a resource_string can't be spawned, only a uri; {known}", _Response.UNSUPPORTED_FORMAT
            )
        raise RequestFailed(f"neither uri nor resource_string is given; {known}", _Response.NO_RESOURCE)
    if request.uri not in spawnables:
        ours = request.uri.startswith((_ROBOT_TYPE, _LIKE))
        code = Result.RESULT_NOT_FOUND if ours else _Response.UNSUPPORTED_FORMAT
        raise RequestFailed(f"nothing to spawn of uri {request.uri[:200]!r}; {known}", code)
    return spawnables[request.uri]


def _new_name(simulator: Simulator, request: SpawnEntity.Request, kind: _Spawnable) -> str:
    """Return the name of the new entity.

    Raises:
        RequestFailed: The requested name is invalid, or it is taken and the request does not allow renaming.
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
    numbered = (f"{stem[: _MAX_NAME - len(str(number)) - 1]}_{number}" for number in count(1))
    return next(name for name in numbered if simulator.roster.find(name) is None)


SERVICES = (
    Service(GetSpawnables, _get_spawnables, features=(SimulatorFeatures.SPAWNABLES,)),
    Service(
        SpawnEntity,
        _spawn_entity,
        changes_world=True,
        features=(SimulatorFeatures.SPAWNING,),
        example={"name": "helper", "uri": "robot_type:fetcher", "initial_pose": {"pose": {"position": {"x": 4.0}}}},
    ),
    Service(
        SpawnEntities,
        _spawn_entities,
        changes_world=True,
        features=(SimulatorFeatures.SPAWNING_ENTITIES,),
        example={
            "spawn_requests": [
                {
                    "name": "helper",
                    "entity_resource": {"uri": "robot_type:fetcher"},
                    "initial_pose": {"pose": {"position": {"x": 4.0}}},
                }
            ]
        },
    ),
)
