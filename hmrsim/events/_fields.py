"""Types of fields that several events have, with their descriptions."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

Number = Annotated[float, Field(strict=True)]
Whole = Annotated[int, Field(strict=True)]

RobotName = Annotated[str, Field(description="The robot's name.")]
RobotNames = Annotated[tuple[str, ...], Field(description="The robots' names.")]
ActionName = Annotated[str, Field(description="The action's name, such as `navigate_to_pose`.")]
GoalId = Annotated[str, Field(description="The goal's id: 32 hex digits.")]
Position = Annotated[tuple[Number, Number], Field(description="Where: x, y in the world's unit.")]
LaneName = Annotated[tuple[str, str], Field(description="The lane: the waypoints where it begins and ends.")]
