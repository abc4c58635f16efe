"""Services that query, move and delete robots and items, and list named poses: waypoints, places and docks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from hmrsim.diagnostics import instead
from hmrsim.facilities import Fixture
from hmrsim.geometry import Pose
from hmrsim.goals.fault_effects import no_connection
from hmrsim.interfaces.geometry_msgs import Accel, PoseStamped, Twist
from hmrsim.interfaces.hmrsim_msgs import IsDetected, SetVelocity
from hmrsim.interfaces.simulation_interfaces import (
    DeleteEntity,
    GetEntities,
    GetEntitiesStates,
    GetEntityInfo,
    GetEntityState,
    GetNamedPoseBounds,
    GetNamedPoses,
    NamedPose,
    Result,
    SetEntityState,
    SimulatorFeatures,
)
from hmrsim.robots.robot import Robot
from hmrsim.services import OK, RequestFailed, Service
from hmrsim.services._entities import (
    BadPose,
    check_placement,
    find,
    has_tags,
    info_of,
    matching,
    pose_message,
    read_pose,
    state_of,
)
from hmrsim.simulation.detections import sensors_of
from hmrsim.world.model import Derived

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.world.model import World

_STEERING_SECONDS: Final = 0.5
"""Simulated seconds for which a command applies, so that a robot stops without further ones."""


def _get_entities(simulator: Simulator, request: GetEntities.Request) -> GetEntities.Response:
    return GetEntities.Response(result=OK, entities=[each.name for each in matching(simulator, request.filters)])


def _get_entities_states(simulator: Simulator, request: GetEntitiesStates.Request) -> GetEntitiesStates.Response:
    entities = matching(simulator, request.filters)
    return GetEntitiesStates.Response(
        result=OK,
        entities=[entity.name for entity in entities],
        states=[state_of(simulator, entity) for entity in entities],
    )


def _get_entity_info(simulator: Simulator, request: GetEntityInfo.Request) -> GetEntityInfo.Response:
    return GetEntityInfo.Response(result=OK, info=info_of(simulator, find(simulator, request.entity)))


def _get_entity_state(simulator: Simulator, request: GetEntityState.Request) -> GetEntityState.Response:
    return GetEntityState.Response(result=OK, state=state_of(simulator, find(simulator, request.entity)))


def _set_entity_state(simulator: Simulator, request: SetEntityState.Request) -> None:
    entity, state = find(simulator, request.entity), request.state
    if isinstance(entity, Fixture):
        raise RequestFailed(
            f"{request.entity!r} is a {entity.kind}, which is part of the building and stays where it is"
        )
    if state.twist != Twist() or state.acceleration != Accel():
        raise RequestFailed(
            "a velocity or an acceleration can't be set, only the pose; robots move by their actions alone"
        )
    try:
        pose = read_pose(state.header, state.pose)
        check_placement(simulator, pose, entity.base if isinstance(entity, Robot) else None, entity.name)
    except BadPose as error:
        raise RequestFailed(str(error), SetEntityState.Response.INVALID_POSE) from None
    simulator.roster.move(entity, pose, "moved by set_entity_state")


def _set_velocity(simulator: Simulator, request: SetVelocity.Request) -> None:
    name = request.robot
    robot, goal = _reachable(simulator, name), simulator.dispatcher.goal_of(name)
    if robot.disabled_reasons:
        raise RequestFailed("; ".join(robot.disabled_reasons.values()), Result.RESULT_INCORRECT_STATE)
    if goal is not None:
        raise RequestFailed(f"{name} executes {goal[0]} goal {goal[1]}; cancel it first", Result.RESULT_INCORRECT_STATE)
    if not robot.state.maneuvers and (robot.works or not robot.stands):
        raise RequestFailed(f"{name} is busy; wait until it stands", Result.RESULT_INCORRECT_STATE)
    blocked = robot.steer(request.linear, request.angular, _STEERING_SECONDS)
    if blocked:
        raise RequestFailed(f"{name} stops before {blocked}")


def _delete_entity(simulator: Simulator, request: DeleteEntity.Request) -> None:
    entity = find(simulator, request.entity)
    if isinstance(entity, Fixture):
        raise RequestFailed(f"{entity.name!r} is a {entity.kind}, a part of the building")
    simulator.roster.delete(request.entity)


def _reachable(simulator: Simulator, name: str) -> Robot:
    """Return a robot.

    Raises:
        RequestFailed: There is none of this name, or it has no connection.
    """
    robot = simulator.robots.get(name)
    if robot is None:
        raise RequestFailed(f"robot: no robot {name!r}{instead(name, simulator.robots)}", Result.RESULT_NOT_FOUND)
    if name in simulator.dispatcher.cut_off:
        raise RequestFailed(f"robot: {no_connection(name)}", Result.RESULT_INCORRECT_STATE)
    return robot


def _is_detected(simulator: Simulator, request: IsDetected.Request) -> IsDetected.Response:
    robot = _reachable(simulator, request.robot)
    entity = find(simulator, request.entity)
    if isinstance(entity, Fixture):
        raise RequestFailed(f"entity: {entity.name!r} is a {entity.kind}; sensors see robots and items")
    if not sensors_of(robot):
        raise RequestFailed(f"robot: {robot.name} has no sensor, such as a camera", Result.RESULT_FEATURE_UNSUPPORTED)
    seen = simulator.detections.look_for(robot, entity)
    if seen is None:
        return IsDetected.Response(result=OK)
    pose = PoseStamped.model_validate(robot.stamped(robot.estimated(seen.thing.pose)), strict=False)
    return IsDetected.Response(result=OK, detected=True, pose=pose, by=[*seen.by])


def _read_named_poses(world: World) -> dict[str, NamedPose]:
    """Return the named poses; a name that is used twice, such as of a dock at a place, has one point."""
    tags: dict[str, list[str]] = {}
    for name in world.places:
        tags.setdefault(name, []).append("place")
    for name, dock in world.docks.items():
        tags.setdefault(name, []).extend(dict.fromkeys(("dock", dock.type)))
    for name in world.waypoints:
        tags.setdefault(name, []).append("waypoint")
    return {
        name: NamedPose(
            name=name, description=" and ".join(kinds), tags=kinds, pose=pose_message(Pose(*world.point(name)))
        )
        for name, kinds in tags.items()
    }


_named_poses: Final = Derived(_read_named_poses, "places", "docks", "waypoints")
_all_poses: Final = Derived(
    lambda world: GetNamedPoses.Response(result=OK, poses=[*_named_poses(world).values()]),
    "places",
    "docks",
    "waypoints",
)


def _get_named_poses(simulator: Simulator, request: GetNamedPoses.Request) -> GetNamedPoses.Response:
    if not request.tags.tags:
        return _all_poses(simulator.world)
    poses = [pose for pose in _named_poses(simulator.world).values() if has_tags(pose.tags, request.tags)]
    return GetNamedPoses.Response(result=OK, poses=poses)


def _get_named_pose_bounds(simulator: Simulator, request: GetNamedPoseBounds.Request) -> None:
    # Poses are points here, so they have no bounds.
    known = _named_poses(simulator.world)
    if request.name not in known:
        raise RequestFailed(
            f"no pose {request.name!r}{instead(request.name, known, verb='there are:')}", Result.RESULT_NOT_FOUND
        )


SERVICES = (
    Service(
        GetEntities,
        _get_entities,
        features=(
            SimulatorFeatures.ENTITY_TAGS,
            SimulatorFeatures.ENTITY_CATEGORIES,
            SimulatorFeatures.ENTITY_BOUNDS_BOX,
        ),
        example={"filters": {"filter": "^test"}},
    ),
    Service(GetEntitiesStates, _get_entities_states, features=(SimulatorFeatures.ENTITY_STATE_GETTING,)),
    Service(
        GetEntityInfo, _get_entity_info, features=(SimulatorFeatures.ENTITY_INFO_GETTING,), example={"entity": "tester"}
    ),
    Service(
        GetEntityState,
        _get_entity_state,
        features=(SimulatorFeatures.ENTITY_STATE_GETTING,),
        example={"entity": "tester"},
    ),
    Service(
        SetEntityState,
        _set_entity_state,
        changes_world=True,
        features=(SimulatorFeatures.ENTITY_STATE_SETTING,),
        example={"entity": "tester", "state": {"pose": {"position": {"x": 3.0}}}},
    ),
    Service(SetVelocity, _set_velocity, changes_world=True, example={"robot": "tester", "linear": 0.5, "angular": 0.2}),
    Service(
        DeleteEntity,
        _delete_entity,
        changes_world=True,
        features=(SimulatorFeatures.DELETING,),
        example={"entity": "parcel"},
    ),
    Service(IsDetected, _is_detected, example={"robot": "tester", "entity": "parcel"}),
    Service(
        GetNamedPoses,
        _get_named_poses,
        features=(SimulatorFeatures.NAMED_POSES,),
        example={"tags": {"tags": ["waypoint"]}},
    ),
    Service(
        GetNamedPoseBounds, _get_named_pose_bounds, features=(SimulatorFeatures.POSE_BOUNDS,), example={"name": "there"}
    ),
)
