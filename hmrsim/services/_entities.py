"""Robots, items and fixtures as entities of simulation_interfaces: their info, state, filters and placement."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from typing import TYPE_CHECKING, Final

from hmrsim.diagnostics import instead
from hmrsim.engine.sim_time import nanoseconds
from hmrsim.errors import NoRoute
from hmrsim.facilities import Fixture
from hmrsim.geometry import SAME_PLACE, Pose, yaw_of
from hmrsim.interfaces.builtin_interfaces import Time
from hmrsim.interfaces.geometry_msgs import Point, Quaternion, Twist, Vector3
from hmrsim.interfaces.geometry_msgs import Pose as PoseMessage
from hmrsim.interfaces.nav2_msgs import ComputePathToPose
from hmrsim.interfaces.simulation_interfaces import Bounds, EntityCategory, EntityInfo, EntityState, Result, TagsFilter
from hmrsim.interfaces.std_msgs import Header
from hmrsim.items import Item
from hmrsim.robots.robot import Robot
from hmrsim.services import RequestFailed

if TYPE_CHECKING:
    from hmrsim.interfaces.simulation_interfaces import EntityFilters
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.world.model import Base

    Entity = Robot | Item | Fixture

_MAX_CHARACTERS: Final = 256
_MAX_BYTES: Final = 256 * 1024
"""Memory for a compiled pattern and its search, which also limits their time."""
_FRAMES: Final = ("", "map", "world")
"""The frames of poses in the world's coordinates."""
_CORNERS: Final = 2


class PatternError(ValueError):
    """A pattern that is invalid or too large."""


def compiled(pattern: str) -> Callable[[str], bool]:
    """Return a function that checks whether a text contains a match of a POSIX extended regular expression.

    Matching takes time linear in the text, whatever pattern a client sends. The syntax is that of RE2's POSIX mode:
    a backslash also escapes between brackets, and there are neither collating elements (``[.x.]``, ``[=x=]``) nor
    repetitions of more than 1000.

    Raises:
        PatternError: The pattern is invalid or too large.
    """
    if not pattern:
        return lambda _text: True
    if len(pattern) > _MAX_CHARACTERS:
        raise PatternError(f"it has {len(pattern)} characters; at most {_MAX_CHARACTERS} are allowed")
    # The library takes 15 ms to load, and few simulations filter entities by name.
    import re2  # noqa: PLC0415

    options = re2.Options()
    options.posix_syntax = options.one_line = options.dot_nl = options.never_capture = True
    options.log_errors = False
    options.max_mem = _MAX_BYTES
    try:
        expression = re2.compile(pattern, options)
    except re2.error as error:
        raise PatternError(error.args[0].decode()) from None
    except UnicodeEncodeError:
        raise PatternError("it has an unpaired surrogate") from None
    return lambda text: expression.search(text) is not None


class BadPose(ValueError):
    """A pose where no entity can be placed; the message gives the reason."""


def find(simulator: Simulator, name: str) -> Entity:
    """Return the entity of a name.

    Raises:
        RequestFailed: There is none.
    """
    entity = simulator.roster.find(name)
    if entity is None:
        names = sorted(entity.name for entity in simulator.roster)
        raise RequestFailed(f"no entity {name!r}{instead(name, names, verb='there are:')}", Result.RESULT_NOT_FOUND)
    return entity


def pose_message(pose: Pose) -> PoseMessage:
    """Return a pose in the plane as a message."""
    facing = Quaternion(z=math.sin(pose.yaw / 2), w=math.cos(pose.yaw / 2))
    return PoseMessage(position=Point(x=pose.x, y=pose.y), orientation=facing)


def state_of(simulator: Simulator, entity: Entity) -> EntityState:
    """Return an entity's pose and velocity; a carried item has those of its robot."""
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


def _pose(entity: Entity) -> Pose:
    if isinstance(entity, Fixture):
        return entity.pose
    return entity.pose() if isinstance(entity, Robot) else Pose(*entity.position)


def info_of(simulator: Simulator, entity: Entity) -> EntityInfo:
    """Return the category, description and tags of an entity."""
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


def has_tags(tags: Collection[str], tags_filter: TagsFilter) -> bool:
    """Return whether tags pass a filter; an empty filter passes all."""
    quantifier = all if tags_filter.filter_mode == TagsFilter.FILTER_MODE_ALL else any
    return not tags_filter.tags or quantifier(tag in tags for tag in tags_filter.tags)


def matching(simulator: Simulator, filters: EntityFilters) -> list[Entity]:
    """Return the entities that pass all filters.

    Raises:
        RequestFailed: A filter is invalid.
    """
    categories = {category.category for category in filters.categories}
    try:
        has_name = compiled(filters.filter)
    except PatternError as error:
        raise RequestFailed(f"filter {filters.filter[:100]!r}: {error}") from None

    def passes(entity: Entity) -> bool:
        info = info_of(simulator, entity)
        return (
            has_name(entity.name)
            and (not categories or info.category.category in categories)
            and has_tags(info.tags, filters.tags)
            and _is_inside(entity, filters.bounds)
        )

    return list(filter(passes, simulator.roster))


def _is_inside(entity: Entity, bounds: Bounds) -> bool:
    """Return whether an entity, as a point in the plane, is inside bounds."""
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
    """Return the pose in the plane that a message describes.

    Raises:
        BadPose: The message has another frame, or its orientation is tilted or all zero.
    """
    if header.frame_id not in _FRAMES:
        raise BadPose(f"unknown frame_id {header.frame_id!r}; use 'map' or leave it empty")
    facing = pose.orientation
    length = math.hypot(facing.x, facing.y, facing.z, facing.w)
    if length <= SAME_PLACE:
        raise BadPose("the orientation is all zero, which is invalid; (0, 0, 0, 1) is straight ahead")
    if math.hypot(facing.x, facing.y) > SAME_PLACE * length:
        raise BadPose("the orientation is tilted; in the plane, its x and y are 0")
    return Pose(pose.position.x, pose.position.y, yaw_of(facing.z, facing.w))


def check_placement(simulator: Simulator, pose: Pose, base: Base | None, name: str = "") -> None:
    """Check that there is room at a pose for a robot with a base, or for an item if the base is None.

    Items may lie inside obstacles, such as shelves, and next to anything.

    Raises:
        BadPose: The point is invalid, or the footprint overlaps that of a robot other than *name*.
    """
    point = x, y = pose.point
    try:
        simulator.graph.check_start(point)
    except NoRoute as error:
        if base is not None or error.code != ComputePathToPose.Result.START_OCCUPIED:
            raise BadPose(str(error).removeprefix("start ")) from None
    if base is None or base.flies:
        return
    radius = base.radius or 0.0
    for other in simulator.robots.values():
        room = max(SAME_PLACE, radius + other.radius)
        if other.motion.is_within(room, point) and other.name != name and not other.flies:
            raise BadPose(f"({x:g}, {y:g}) is {other.distance_to(point):.3g} from {other.name}; keep {room:g} away")
    full = simulator.roster.admission.full_at(point, radius, name)
    if full is not None:
        raise BadPose(f"({x:g}, {y:g}) {full}, where there is no room for one more robot")
