"""Events as another package would define them."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from hmrsim.events import Event, EventGroup


class FloorCleaned(Event, kind="floor_cleaned", severity="info", text="has cleaned {area} m² of {room}"):
    """A robot has cleaned a room."""

    robot: Annotated[str, Field(description="The robot's name.")]
    room: Annotated[str, Field(description="The room's name.")]
    area: Annotated[float, Field(description="In square meters.")]


class BrushWorn(Event, kind="brush_worn", severity="warning", text="has a worn brush"):
    """A robot's brush is worn out."""

    robot: Annotated[str, Field(description="The robot's name.")]


EVENTS = EventGroup("cleaning", (FloorCleaned, BrushWorn))
