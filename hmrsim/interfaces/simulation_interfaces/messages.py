"""The messages of the services: results, entities, worlds, and the state of the simulation."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from hmrsim.interfaces.geometry_msgs import Accel, Pose, Twist, Vector3
from hmrsim.interfaces.message import Message, String, UInt8, UInt16
from hmrsim.interfaces.std_msgs import Header


class Result(Message):
    """The result of a request; codes above 100 are the service's own."""

    RESULT_FEATURE_UNSUPPORTED: ClassVar[int] = 0
    RESULT_OK: ClassVar[int] = 1
    RESULT_NOT_FOUND: ClassVar[int] = 2
    RESULT_INCORRECT_STATE: ClassVar[int] = 3
    RESULT_OPERATION_FAILED: ClassVar[int] = 4

    result: UInt8 = 0
    error_message: String = ""


class Bounds(Message):
    """An area: two corners of a box, corners of a convex hull, or centre and radius (as an x) of a sphere."""

    TYPE_EMPTY: ClassVar[int] = 0
    TYPE_BOX: ClassVar[int] = 1
    TYPE_CONVEX_HULL: ClassVar[int] = 2
    TYPE_SPHERE: ClassVar[int] = 3

    type: UInt8 = 0
    points: list[Vector3] = Field(default_factory=list)


class TagsFilter(Message):
    """Tags of which any, or all, are wanted."""

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
    """Which entities are wanted: those that pass all filters; an empty one lets all pass."""

    filter: String = ""
    categories: list[EntityCategory] = Field(default_factory=list)
    tags: TagsFilter = Field(default_factory=TagsFilter)
    bounds: Bounds = Field(default_factory=Bounds)


class EntityInfo(Message):
    """What an entity is."""

    category: EntityCategory = Field(default_factory=EntityCategory)
    description: String = ""
    tags: list[String] = Field(default_factory=list)


class EntityState(Message):
    """Where an entity is and how it moves, seen from the header's frame."""

    header: Header = Field(default_factory=Header)
    pose: Pose = Field(default_factory=Pose)
    twist: Twist = Field(default_factory=Twist)
    acceleration: Accel = Field(default_factory=Accel)


class NamedPose(Message):
    """A pose with a name, for spawning and as a goal."""

    name: String = ""
    description: String = ""
    tags: list[String] = Field(default_factory=list)
    pose: Pose = Field(default_factory=Pose)


class Resource(Message):
    """Where something is described; or, if *uri* is empty, the description itself."""

    uri: String = ""
    resource_string: String = ""


class Spawnable(Message):
    """Something that can be spawned."""

    uri: String = ""
    description: String = ""
    spawn_bounds: Bounds = Field(default_factory=Bounds)


class WorldResource(Message):
    """A world that is loaded, or can be."""

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
    """What a simulator can do, by numbers, and in which formats it reads what is to be spawned."""

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

    features: list[UInt16] = Field(default_factory=list)
    spawn_formats: list[String] = Field(default_factory=list)
    custom_info: String = ""
