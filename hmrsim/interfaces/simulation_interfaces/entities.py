"""Robots and items: finding, spawning, moving and deleting them."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from hmrsim.interfaces.geometry_msgs import PoseStamped
from hmrsim.interfaces.message import Bool, Message, String
from hmrsim.interfaces.simulation_interfaces.messages import (
    Bounds,
    EntityFilters,
    EntityInfo,
    EntityState,
    NamedPose,
    Result,
    Spawnable,
    TagsFilter,
)


class GetSpawnables:
    """Ask what can be spawned."""

    class Request(Message):
        """Where to look for more."""

        sources: list[String] = Field(default_factory=list)

    class Response(Message):
        """What can be, by the URIs for SpawnEntity."""

        result: Result = Field(default_factory=Result)
        spawnables: list[Spawnable] = Field(default_factory=list)


class SpawnEntity:
    """Put a robot or an item into the world."""

    class Request(Message):
        """What, where, and by which name."""

        name: String = ""
        allow_renaming: Bool = False
        uri: String = ""
        resource_string: String = ""
        entity_namespace: String = ""
        initial_pose: PoseStamped = Field(default_factory=PoseStamped)

    class Response(Message):
        """What came of it, and the name that it has."""

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


class DeleteEntity:
    """Take an entity out of the world."""

    class Request(Message):
        """Which."""

        entity: String = ""

    class Response(Message):
        """What came of it."""

        result: Result = Field(default_factory=Result)


class GetEntities:
    """Ask who and what is in the world."""

    class Request(Message):
        """Of which kind."""

        filters: EntityFilters = Field(default_factory=EntityFilters)

    class Response(Message):
        """Their names."""

        result: Result = Field(default_factory=Result)
        entities: list[String] = Field(default_factory=list)


class GetEntitiesStates:
    """Ask where entities are."""

    class Request(Message):
        """Which entities."""

        filters: EntityFilters = Field(default_factory=EntityFilters)

    class Response(Message):
        """Their names and, in the same order, their states."""

        result: Result = Field(default_factory=Result)
        entities: list[String] = Field(default_factory=list)
        states: list[EntityState] = Field(default_factory=list)


class GetEntityInfo:
    """Ask what an entity is."""

    class Request(Message):
        """Which."""

        entity: String = ""

    class Response(Message):
        """What it is."""

        result: Result = Field(default_factory=Result)
        info: EntityInfo = Field(default_factory=EntityInfo)


class GetEntityState:
    """Ask where an entity is."""

    class Request(Message):
        """Which."""

        entity: String = ""

    class Response(Message):
        """Where it is."""

        result: Result = Field(default_factory=Result)
        state: EntityState = Field(default_factory=EntityState)


class SetEntityState:
    """Put an entity somewhere else."""

    class Request(Message):
        """Which, and where."""

        entity: String = ""
        state: EntityState = Field(default_factory=EntityState)

    class Response(Message):
        """What came of it."""

        INVALID_POSE: ClassVar[int] = 101

        result: Result = Field(default_factory=Result)


class GetNamedPoses:
    """Ask for the poses that have a name."""

    class Request(Message):
        """Of which tags."""

        tags: TagsFilter = Field(default_factory=TagsFilter)

    class Response(Message):
        """All of them."""

        result: Result = Field(default_factory=Result)
        poses: list[NamedPose] = Field(default_factory=list)


class GetNamedPoseBounds:
    """Ask how much room a pose has."""

    class Request(Message):
        """Which."""

        name: String = ""

    class Response(Message):
        """How much."""

        result: Result = Field(default_factory=Result)
        bounds: Bounds = Field(default_factory=Bounds)
