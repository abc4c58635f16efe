"""Robots and items that come, go, or are moved by a service."""

from __future__ import annotations

from typing import Annotated, Final

from pydantic import Field

from hmrsim.events._event import Event, EventGroup
from hmrsim.events._fields import Number, Position
from hmrsim.events._parts import Part

_Entity = Annotated[str, Field(description="The name of the robot or item.")]


class Spawned(
    Event,
    kind="spawned",
    subject=("entity",),
    text="spawned as {type} at {at:point}",
    changes=Part.ENTITIES,
    sets={"present": True},
):
    """A robot or an item was spawned."""

    entity: _Entity
    type: Annotated[str, Field(description="The robot's type, or `item`.")]
    at: Position


class Deleted(
    Event, kind="deleted", subject=("entity",), text="deleted", changes=Part.ENTITIES, sets={"present": False}
):
    """A robot or an item was deleted."""

    entity: _Entity


class Teleported(Event, kind="teleported", subject=("entity",), text="teleported to {at:point}", changes=Part.ENTITIES):
    """A robot or an item was teleported."""

    entity: _Entity
    at: Position
    yaw: Annotated[Number, Field(description="Which way it faces, in radians.")]


EVENTS: Final = EventGroup("entities", (Spawned, Deleted, Teleported))
