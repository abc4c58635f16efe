"""Items that robots handle."""

from __future__ import annotations

from typing import Annotated, Final

from pydantic import Field

from hmrsim.events._event import Event, EventGroup
from hmrsim.events._fields import Position, RobotName
from hmrsim.events._parts import Part


class ItemEvent(Event, changes=Part.CARRIER):
    """Something about an item that a robot handles."""

    robot: RobotName
    item: Annotated[str, Field(description="The item's name.")]


class ItemPicked(ItemEvent, kind="picked", text="picks up {item}", sets={"carried": True}):
    """A robot picks up an item."""


class ItemPlaced(ItemEvent, kind="placed", text="puts down {item} at {at:point}", sets={"carried": False}):
    """A robot puts down an item."""

    at: Position


class ItemDropped(
    ItemEvent, kind="dropped", severity="warning", text="drops {item} at {at:point}", sets={"carried": False}
):
    """A robot drops an item, which then blocks its lane."""

    at: Position


EVENTS: Final = EventGroup("items", (ItemPicked, ItemPlaced, ItemDropped))
