"""The services of ROS's package simulation_interfaces, version 1.6.1 of ROS kilted.

In this first series of the package, a resource to spawn or to load is two fields and not a message.
"""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field

from hmrsim.interfaces.geometry_msgs import Accel, Pose, PoseStamped, Twist, Vector3
from hmrsim.interfaces.message import Bool, Message, String, UInt8, UInt16, UInt64
from hmrsim.interfaces.quantities import STEPS
from hmrsim.interfaces.std_msgs import Header


class Result(Message):
    """The result of a request; each service defines its own codes above 100."""

    RESULT_FEATURE_UNSUPPORTED: ClassVar[int] = 0
    RESULT_OK: ClassVar[int] = 1
    RESULT_NOT_FOUND: ClassVar[int] = 2
    RESULT_INCORRECT_STATE: ClassVar[int] = 3
    RESULT_OPERATION_FAILED: ClassVar[int] = 4

    result: UInt8 = 0
    error_message: String = ""


_ServiceResult = Result
"""The name of `Result` inside `SimulateSteps.Result`, where ``Result`` means the action's."""


class Bounds(Message):
    """An area: two corners of a box, corners of a convex hull, or center and radius (as an x) of a sphere."""

    TYPE_EMPTY: ClassVar[int] = 0
    TYPE_BOX: ClassVar[int] = 1
    TYPE_CONVEX_HULL: ClassVar[int] = 2
    TYPE_SPHERE: ClassVar[int] = 3

    type: UInt8 = 0
    points: list[Vector3] = Field(default_factory=list)


class TagsFilter(Message):
    """Tags to match, either any or all of them."""

    FILTER_MODE_ANY: ClassVar[int] = 0
    FILTER_MODE_ALL: ClassVar[int] = 1

    tags: list[String] = Field(default_factory=list)
    filter_mode: UInt8 = 0


class EntityCategory(Message):
    """The category of an entity."""

    CATEGORY_OBJECT: ClassVar[int] = 0
    CATEGORY_ROBOT: ClassVar[int] = 1
    CATEGORY_HUMAN: ClassVar[int] = 2
    CATEGORY_DYNAMIC_OBJECT: ClassVar[int] = 4
    CATEGORY_STATIC_OBJECT: ClassVar[int] = 5

    category: UInt8 = 0


class EntityFilters(Message):
    """Filters of entities; an entity has to pass all of them, and an empty filter lets all pass."""

    filter: String = ""
    categories: list[EntityCategory] = Field(default_factory=list)
    tags: TagsFilter = Field(default_factory=TagsFilter)
    bounds: Bounds = Field(default_factory=Bounds)


class EntityInfo(Message):
    """The category, description and tags of an entity."""

    category: EntityCategory = Field(default_factory=EntityCategory)
    description: String = ""
    tags: list[String] = Field(default_factory=list)


class EntityState(Message):
    """The pose, twist and acceleration of an entity, in the header's frame."""

    header: Header = Field(default_factory=Header)
    pose: Pose = Field(default_factory=Pose)
    twist: Twist = Field(default_factory=Twist)
    acceleration: Accel = Field(default_factory=Accel)


class NamedPose(Message):
    """A named pose, for spawning and as a goal."""

    name: String = ""
    description: String = ""
    tags: list[String] = Field(default_factory=list)
    pose: Pose = Field(default_factory=Pose)


class Resource(Message):
    """The URI of a description or, if *uri* is empty, the description itself."""

    uri: String = ""
    resource_string: String = ""


class Spawnable(Message):
    """A robot type or item that can be spawned."""

    uri: String = ""
    description: String = ""
    spawn_bounds: Bounds = Field(default_factory=Bounds)


class WorldResource(Message):
    """A world that is loaded or can be loaded."""

    name: String = ""
    world_resource: Resource = Field(default_factory=Resource)
    description: String = ""
    tags: list[String] = Field(default_factory=list)


class SimulationState(Message):
    """The state of the simulation."""

    STATE_STOPPED: ClassVar[int] = 0
    STATE_PLAYING: ClassVar[int] = 1
    STATE_PAUSED: ClassVar[int] = 2
    STATE_QUITTING: ClassVar[int] = 3
    STATE_NO_WORLD: ClassVar[int] = 4
    STATE_LOADING_WORLD: ClassVar[int] = 5

    state: UInt8 = 0


class SimulatorFeatures(Message):
    """The simulator's features, by number, and the formats in which it reads resources to spawn."""

    SPAWNING: ClassVar[int] = 0
    DELETING: ClassVar[int] = 1
    NAMED_POSES: ClassVar[int] = 2
    POSE_BOUNDS: ClassVar[int] = 3
    ENTITY_TAGS: ClassVar[int] = 4
    ENTITY_BOUNDS: ClassVar[int] = 5
    ENTITY_BOUNDS_BOX: ClassVar[int] = 6
    ENTITY_BOUNDS_CONVEX: ClassVar[int] = 7
    ENTITY_CATEGORIES: ClassVar[int] = 8
    SPAWNING_RESOURCE_STRING: ClassVar[int] = 9
    ENTITY_STATE_GETTING: ClassVar[int] = 10
    ENTITY_STATE_SETTING: ClassVar[int] = 11
    ENTITY_INFO_GETTING: ClassVar[int] = 12
    ENTITY_INFO_SETTING: ClassVar[int] = 13
    SPAWNABLES: ClassVar[int] = 14
    SIMULATION_RESET: ClassVar[int] = 20
    SIMULATION_RESET_TIME: ClassVar[int] = 21
    SIMULATION_RESET_STATE: ClassVar[int] = 22
    SIMULATION_RESET_SPAWNED: ClassVar[int] = 23
    SIMULATION_STATE_GETTING: ClassVar[int] = 24
    SIMULATION_STATE_SETTING: ClassVar[int] = 25
    SIMULATION_STATE_PAUSE: ClassVar[int] = 26
    STEP_SIMULATION_SINGLE: ClassVar[int] = 31
    STEP_SIMULATION_MULTIPLE: ClassVar[int] = 32
    STEP_SIMULATION_ACTION: ClassVar[int] = 33
    WORLD_LOADING: ClassVar[int] = 40
    WORLD_RESOURCE_STRING: ClassVar[int] = 41
    WORLD_TAGS: ClassVar[int] = 42
    WORLD_UNLOADING: ClassVar[int] = 43
    WORLD_INFO_GETTING: ClassVar[int] = 44
    AVAILABLE_WORLDS: ClassVar[int] = 45
    SPAWNING_ENTITIES: ClassVar[int] = 50

    features: list[UInt16] = Field(default_factory=list)
    spawn_formats: list[String] = Field(default_factory=list)
    custom_info: String = ""


class GetSpawnables:
    """List the robots and items that can be spawned."""

    class Request(Message):
        """Further sources of entities that can be spawned."""

        sources: list[String] = Field(default_factory=list)

    class Response(Message):
        """The spawnables, with the URIs to pass to SpawnEntity."""

        result: Result = Field(default_factory=Result)
        spawnables: list[Spawnable] = Field(default_factory=list)


class SpawnEntity(Message):
    """Put a robot or an item into the world; this is a service and also a message, one request of `SpawnEntities`."""

    name: String = ""
    allow_renaming: Bool = False
    entity_resource: Resource = Field(default_factory=Resource)
    entity_namespace: String = ""
    initial_pose: PoseStamped = Field(default_factory=PoseStamped)

    class Request(Message):
        """The entity's name, URI and initial pose."""

        name: String = ""
        allow_renaming: Bool = False
        uri: String = ""
        resource_string: String = ""
        entity_namespace: String = ""
        initial_pose: PoseStamped = Field(default_factory=PoseStamped)

    class Response(Message):
        """The result, and the name that the entity got."""

        NAME_NOT_UNIQUE: ClassVar[int] = 101
        NAME_INVALID: ClassVar[int] = 102
        UNSUPPORTED_FORMAT: ClassVar[int] = 103
        NO_RESOURCE: ClassVar[int] = 104
        NAMESPACE_INVALID: ClassVar[int] = 105
        RESOURCE_PARSE_ERROR: ClassVar[int] = 106
        MISSING_ASSETS: ClassVar[int] = 107
        UNSUPPORTED_ASSETS: ClassVar[int] = 108
        INVALID_POSE: ClassVar[int] = 109

        result: Result = Field(default_factory=Result)
        entity_name: String = ""


class SpawnResult(Message):
    """The result of one request of `SpawnEntities`, with the codes of `SpawnEntity`."""

    result: Result = Field(default_factory=Result)
    entity_name: String = ""


class SpawnEntities:
    """Put several robots and items into the world."""

    class Request(Message):
        """The entities that the service spawns."""

        spawn_requests: list[SpawnEntity] = Field(default_factory=list)

    class Response(Message):
        """The result of all requests, and of each."""

        ENTITIES_SPAWN_FAILED: ClassVar[int] = 150

        result: Result = Field(default_factory=Result)
        results: list[SpawnResult] = Field(default_factory=list)


class DeleteEntity:
    """Remove an entity from the world."""

    class Request(Message):
        """The name of the entity to remove."""

        entity: String = ""

    class Response(Message):
        """The result of the request."""

        result: Result = Field(default_factory=Result)


class GetEntities:
    """List the entities in the world."""

    class Request(Message):
        """Filters that the entities have to pass."""

        filters: EntityFilters = Field(default_factory=EntityFilters)

    class Response(Message):
        """The names of the entities."""

        result: Result = Field(default_factory=Result)
        entities: list[String] = Field(default_factory=list)


class GetEntitiesStates:
    """Return the states of entities."""

    class Request(Message):
        """Filters that the entities have to pass."""

        filters: EntityFilters = Field(default_factory=EntityFilters)

    class Response(Message):
        """The names of the entities and, in the same order, their states."""

        result: Result = Field(default_factory=Result)
        entities: list[String] = Field(default_factory=list)
        states: list[EntityState] = Field(default_factory=list)


class GetEntityInfo:
    """Return the category, description and tags of an entity."""

    class Request(Message):
        """The name of the entity."""

        entity: String = ""

    class Response(Message):
        """The entity's category, description and tags."""

        result: Result = Field(default_factory=Result)
        info: EntityInfo = Field(default_factory=EntityInfo)


class GetEntityState:
    """Return the state of an entity."""

    class Request(Message):
        """The name of the entity."""

        entity: String = ""

    class Response(Message):
        """The entity's pose and velocity."""

        result: Result = Field(default_factory=Result)
        state: EntityState = Field(default_factory=EntityState)


class SetEntityState:
    """Move an entity to another pose."""

    class Request(Message):
        """The name of the entity and its new state."""

        entity: String = ""
        state: EntityState = Field(default_factory=EntityState)

    class Response(Message):
        """The result of the request."""

        INVALID_POSE: ClassVar[int] = 101

        result: Result = Field(default_factory=Result)


class GetNamedPoses:
    """List the named poses."""

    class Request(Message):
        """The tags that a pose must have."""

        tags: TagsFilter = Field(default_factory=TagsFilter)

    class Response(Message):
        """The named poses with all tags requested."""

        result: Result = Field(default_factory=Result)
        poses: list[NamedPose] = Field(default_factory=list)


class GetNamedPoseBounds:
    """Return the room around a named pose."""

    class Request(Message):
        """The name of the pose."""

        name: String = ""

    class Response(Message):
        """The bounds of the pose."""

        result: Result = Field(default_factory=Result)
        bounds: Bounds = Field(default_factory=Bounds)


class GetSimulatorFeatures:
    """List the features of the simulator."""

    class Request(Message):
        """The request, which has no fields."""

    class Response(Message):
        """The features of the simulator."""

        features: SimulatorFeatures = Field(default_factory=SimulatorFeatures)


class GetSimulationState:
    """Return whether the simulation is playing, paused or stopped."""

    class Request(Message):
        """The request, which has no fields."""

    class Response(Message):
        """The state of the simulation."""

        state: SimulationState = Field(default_factory=SimulationState)
        result: Result = Field(default_factory=Result)


class SetSimulationState:
    """Play, pause or stop the simulation."""

    class Request(Message):
        """The new state of the simulation."""

        state: SimulationState = Field(default_factory=SimulationState)

    class Response(Message):
        """The result of the request."""

        ALREADY_IN_TARGET_STATE: ClassVar[int] = 101
        STATE_TRANSITION_ERROR: ClassVar[int] = 102
        INCORRECT_TRANSITION: ClassVar[int] = 103

        result: Result = Field(default_factory=Result)


class StepSimulation:
    """Advance a paused simulation by a number of steps."""

    class Request(Message):
        """The number of steps to take."""

        steps: Annotated[UInt64, STEPS] = 1

    class Response(Message):
        """The result, when all steps are done."""

        result: Result = Field(default_factory=Result)


class SimulateSteps:
    """Advance a paused simulation by a number of steps and report each of them."""

    class Goal(Message):
        """The number of steps to take."""

        steps: UInt64 = 0

    class Result(Message):
        """The result of the request."""

        result: _ServiceResult = Field(default_factory=_ServiceResult)

    class Feedback(Message):
        """The numbers of steps that are done and that are left."""

        completed_steps: UInt64 = 0
        remaining_steps: UInt64 = 0


class ResetSimulation:
    """Reset the simulation."""

    class Request(Message):
        """The scopes to reset, as bits."""

        SCOPE_DEFAULT: ClassVar[int] = 0
        SCOPE_TIME: ClassVar[int] = 1
        SCOPE_STATE: ClassVar[int] = 2
        SCOPE_SPAWNED: ClassVar[int] = 4
        SCOPE_ALL: ClassVar[int] = 255

        scope: UInt8 = 0

    class Response(Message):
        """The result of the request."""

        result: Result = Field(default_factory=Result)


class LoadWorld:
    """Replace the world by another one."""

    class Request(Message):
        """The file or name of the world, or its text."""

        uri: String = ""
        resource_string: String = ""
        fail_on_unsupported_element: Bool = False
        ignore_missing_or_unsupported_assets: Bool = False

    class Response(Message):
        """The result and the loaded world."""

        UNSUPPORTED_FORMAT: ClassVar[int] = 101
        NO_RESOURCE: ClassVar[int] = 102
        RESOURCE_PARSE_ERROR: ClassVar[int] = 103
        MISSING_ASSETS: ClassVar[int] = 104
        UNSUPPORTED_ASSETS: ClassVar[int] = 105
        UNSUPPORTED_ELEMENTS: ClassVar[int] = 106

        result: Result = Field(default_factory=Result)
        world: WorldResource = Field(default_factory=WorldResource)


class GetCurrentWorld:
    """Return the loaded world."""

    class Request(Message):
        """The request, which has no fields."""

    class Response(Message):
        """The world that is loaded."""

        NO_WORLD_LOADED: ClassVar[int] = 101

        result: Result = Field(default_factory=Result)
        world: WorldResource = Field(default_factory=WorldResource)


class GetAvailableWorlds:
    """List the worlds that can be loaded."""

    class Request(Message):
        """Further sources of worlds, and the tags that a world must have."""

        additional_sources: list[String] = Field(default_factory=list)
        filter: TagsFilter = Field(default_factory=TagsFilter)
        offline_only: Bool = False
        continue_on_error: Bool = False

    class Response(Message):
        """The worlds that were found."""

        DEFAULT_SOURCES_FAILED: ClassVar[int] = 101

        result: Result = Field(default_factory=Result)
        worlds: list[WorldResource] = Field(default_factory=list)
