"""Robots and items that come, go, or are moved by a service."""

from __future__ import annotations

from typing import Annotated, Final

from pydantic import Field

from hmrsim.events._event import Event, EventGroup
from hmrsim.events._fields import Number, Position
from hmrsim.events._parts import Part


class EntityEvent(Event, subject=("entity",), changes=Part.ENTITIES):
    """Something about a robot or an item."""

    entity: Annotated[str, Field(description="The name of the robot or item.")]


class Spawned(EntityEvent, kind="spawned", text="spawned as {type} at {at:point}", sets={"present": True}):
    """A robot or an item was spawned."""

    type: Annotated[str, Field(description="The robot's type, or `item`.")]
    at: Position


class Deleted(EntityEvent, kind="deleted", text="deleted", sets={"present": False}):
    """A robot or an item was deleted."""


class Teleported(EntityEvent, kind="teleported", text="teleported to {at:point}"):
    """A robot or an item was teleported."""

    at: Position
    yaw: Annotated[Number, Field(description="Which way it faces, in radians.")]


EVENTS: Final = EventGroup("entities", (Spawned, Deleted, Teleported))
