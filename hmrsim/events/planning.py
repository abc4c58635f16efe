"""The external planner."""

from __future__ import annotations

from typing import Annotated, Final

from pydantic import Field

from hmrsim.events._event import Event, EventGroup
from hmrsim.events._fields import RobotName, Whole
from hmrsim.events._parts import Part


class PlanRequested(
    Event, kind="plan_wanted", severity="debug", text="requests a path from the external planner (request {request})"
):
    """A robot needs a path of the external planner."""

    robot: RobotName
    request: Annotated[Whole, Field(description="The number of the request.")]


class PlannerChanged(
    Event,
    kind="planner",
    severity="[{present=false}warning|info]",
    subject=(),
    text="[{present=true}an external planner is available|no external planner is available]",
    changes=Part.PLANNER,
):
    """An external planner has become available, or the last one has gone."""

    present: Annotated[bool, Field(strict=True, description="Whether there is one now.")]


EVENTS: Final = EventGroup("planning", (PlanRequested, PlannerChanged))
