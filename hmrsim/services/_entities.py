"""Robots and items as simulation_interfaces sees them: entities, with a category, tags and a state."""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import TYPE_CHECKING

from hmrsim.diagnostics import instead
from hmrsim.engine.sim_time import nanoseconds
from hmrsim.facilities import Fixture
from hmrsim.geometry import SAME_PLACE, Pose, yaw_of
from hmrsim.interfaces.builtin_interfaces import Time
from hmrsim.interfaces.geometry_msgs import Point, Quaternion, Twist, Vector3
from hmrsim.interfaces.geometry_msgs import Pose as PoseMessage
from hmrsim.interfaces.simulation_interfaces import Bounds, EntityCategory, EntityInfo, EntityState, Result, TagsFilter
from hmrsim.interfaces.std_msgs import Header
from hmrsim.items import Item
from hmrsim.robots.robot import Robot
from hmrsim.services._pattern import PatternError, compiled
from hmrsim.services._results import RequestFailed, failed

if TYPE_CHECKING:
    from hmrsim.interfaces.simulation_interfaces import EntityFilters
    from hmrsim.simulation.simulator import Simulator

_FRAMES = ("", "map", "world")
_CORNERS = 2


class BadPose(ValueError):
    """No entity can be placed at a pose; the text says why."""


def unknown(simulator: Simulator, name: str) -> Result:
    """Return the result of a request for an entity that does not exist."""
    there = sorted(entity.name for entity in simulator.roster)
    return failed(f"no entity {name!r}{instead(name, there, verb='there are:')}", Result.RESULT_NOT_FOUND)


def pose_message(pose: Pose) -> PoseMessage:
    """Return a pose in the plane as a message."""
    facing = Quaternion(z=math.sin(pose.yaw / 2), w=math.cos(pose.yaw / 2))
    return PoseMessage(position=Point(x=pose.x, y=pose.y), orientation=facing)


def state_of(simulator: Simulator, entity: Robot | Item | Fixture) -> EntityState:
    """Return where an entity is and how it moves; a carried item moves as its robot does."""
    robot = entity if isinstance(entity, Robot) else entity.carrier if isinstance(entity, Item) else None
    pose = robot.pose() if robot is not None else _pose(entity)
    ahead, turning = robot.velocity() if robot is not None else (0.0, 0.0)
    return EntityState(
        header=Header(stamp=Time.from_nanoseconds(nanoseconds(simulator.now)), frame_id="map"),
        pose=pose_message(pose),
        twist=Twist(
            linear=Vector3(x=ahead * math.cos(pose.yaw), y=ahead * math.sin(pose.yaw)), angular=Vector3(z=turning)
        ),
    )


def _pose(entity: Robot | Item | Fixture) -> Pose:
    if isinstance(entity, Fixture):
        return entity.pose
    return entity.pose() if isinstance(entity, Robot) else Pose(*entity.position)


def info_of(simulator: Simulator, entity: Robot | Item | Fixture) -> EntityInfo:
    """Return what an entity is."""
    spawned = ["spawned"] if entity.name in simulator.roster.spawned else []
    blocking = ["blocking"] if simulator.roster.admission.closures.is_obstructed_by(entity.name) else []
    if isinstance(entity, Robot):
        carried = list(entity.components)
        description = f"{entity.type} with {', '.join(carried)}" if carried else entity.type
        state = ["waiting"] if entity.waits else []
        state += [f"docked:{entity.dock.name}"] if entity.dock else []
        state += entity.energy.tags if entity.energy else []
        state += sorted({*entity.disabled_reasons, *simulator.fault_injector.active_on(entity.name)})
        category, tags = EntityCategory.CATEGORY_ROBOT, ["robot", entity.type, *carried, *state]
    elif isinstance(entity, Fixture):
        category, tags, description = EntityCategory.CATEGORY_STATIC_OBJECT, entity.tags, entity.description
    else:
        carried = [f"carried_by:{entity.carrier.name}"] if entity.carrier else []
        category, tags = EntityCategory.CATEGORY_DYNAMIC_OBJECT, ["item", *carried]
        description = f"item of {entity.weight:g} kg"
    tags = [*tags, *blocking, *spawned]
    return EntityInfo(category=EntityCategory(category=category), description=description, tags=tags)


def has_tags(tags: Collection[str], wanted: TagsFilter) -> bool:
    """Return whether tags pass a filter; an empty filter passes all."""
    how = all if wanted.filter_mode == TagsFilter.FILTER_MODE_ALL else any
    return not wanted.tags or how(tag in tags for tag in wanted.tags)


def matching(simulator: Simulator, filters: EntityFilters) -> list[Robot | Item | Fixture] | Result:
    """Return the entities that pass all filters, or the error of a filter."""
    categories = {one.category for one in filters.categories}
    found = []
    try:
        named = compiled(filters.filter)
        for entity in simulator.roster:
            info = info_of(simulator, entity)
            if (
                named(entity.name)
                and (not categories or info.category.category in categories)
                and has_tags(info.tags, filters.tags)
                and _is_inside(entity, filters.bounds)
            ):
                found.append(entity)
    except PatternError as error:
        return failed(f"filter {filters.filter[:100]!r}: {error}")
    except RequestFailed as error:
        return failed(str(error), error.code)
    return found


def _is_inside(entity: Robot | Item | Fixture, bounds: Bounds) -> bool:
    """Return whether an entity is inside bounds; entities are points in the plane."""
    if bounds.type == Bounds.TYPE_EMPTY:
        return True
    if bounds.type not in (Bounds.TYPE_BOX, Bounds.TYPE_SPHERE):
        message = f"bounds of type {bounds.type} are not supported; use a box or a sphere"
        raise RequestFailed(message, Result.RESULT_FEATURE_UNSUPPORTED)
    if len(bounds.points) != _CORNERS:
        raise RequestFailed(f"a box or a sphere has 2 points, got {len(bounds.points)}")
    x, y = _pose(entity).point
    a, b = bounds.points
    if bounds.type == Bounds.TYPE_SPHERE:
        return math.dist((a.x, a.y, a.z), (x, y, 0.0)) <= b.x
    axes = ((a.x, b.x, x), (a.y, b.y, y), (a.z, b.z, 0.0))
    return all(min(low, high) <= value <= max(low, high) for low, high, value in axes)


def read_pose(header: Header, pose: PoseMessage) -> Pose:
    """Return the pose in the plane that a message asks for.

    Raises:
        BadPose: It is in another frame, or its orientation is tilted or all zero.
    """
    if header.frame_id not in _FRAMES:
        raise BadPose(f"unknown frame_id {header.frame_id!r}; use 'map' or leave it empty")
    facing = pose.orientation
    length = math.hypot(facing.x, facing.y, facing.z, facing.w)
    if length <= SAME_PLACE:
        raise BadPose("the orientation is all zero, which is invalid; (0, 0, 0, 1) is straight ahead")
    if math.hypot(facing.x, facing.y) > SAME_PLACE * length:
        raise BadPose("the orientation is tilted; on a plane x and y of it are 0")
    return Pose(pose.position.x, pose.position.y, yaw_of(facing.z, facing.w))
