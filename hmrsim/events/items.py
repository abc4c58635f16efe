"""Items that robots handle."""

from __future__ import annotations

from typing import Annotated, Final

from pydantic import Field

from hmrsim.events._event import Event, EventGroup
from hmrsim.events._fields import Position, RobotName
from hmrsim.events._parts import Part

_ItemName = Annotated[str, Field(description="The item's name.")]


class ItemPicked(Event, kind="picked", text="picks up {item}", changes=Part.CARRIER, sets={"carried": True}):
    """A robot picks up an item."""

    robot: RobotName
    item: _ItemName


class ItemPlaced(
    Event, kind="placed", text="puts down {item} at {at:point}", changes=Part.CARRIER, sets={"carried": False}
):
    """A robot puts down an item."""

    robot: RobotName
    item: _ItemName
    at: Position


class ItemDropped(
    Event,
    kind="dropped",
    severity="warning",
    text="drops {item} at {at:point}",
    changes=Part.CARRIER,
    sets={"carried": False},
):
    """A robot drops an item, which then blocks its lane."""

    robot: RobotName
    item: _ItemName
    at: Position


EVENTS: Final = EventGroup("items", (ItemPicked, ItemPlaced, ItemDropped))
