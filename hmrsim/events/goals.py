"""Goals of actions: accepted, under way, ended, rejected."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Final

from pydantic import Field

from hmrsim.events._event import Event, EventGroup
from hmrsim.events._fields import ActionName, GoalId, RobotName, Whole
from hmrsim.events._parts import Part


class GoalAccepted(Event, kind="goal", text="{action} accepted[: {goal:goal}]", traced=False, changes=Part.GOALS):
    """The goal message of a goal that is about to be accepted."""

    robot: RobotName
    action: ActionName
    goal_id: GoalId
    goal: Annotated[
        Mapping[str, Any] | None,
        Field(description="The action's goal message; fields with ROS's default are left out."),
    ]


class GoalStatusChanged(
    Event,
    kind="status",
    severity="[{status=6}error|{status=5}warning|{status=4}info|debug]",
    text="{action} [{status=1}ACCEPTED|{status=2}EXECUTING|{status=3}CANCELING|{status=4}SUCCEEDED|{status=5}CANCELED|"
    "{status=6}ABORTED|status {status}][{status=6}: {result:error}]",
    changes=Part.GOALS,
):
    """A goal has another status."""

    robot: RobotName
    action: ActionName
    goal_id: GoalId
    status: Annotated[Whole, Field(description="Of action_msgs/msg/GoalStatus; 4, 5 and 6 are terminal.")]
    result: Annotated[
        Mapping[str, Any] | None, Field(description="The action's result message, of a goal that has ended.")
    ] = None
    cause: Annotated[
        str | None, Field(description="Why it did not succeed, as an identifier, such as `preempted`.")
    ] = None


class SendGoalRejected(Event, kind="rejected", severity="warning", text="{action} rejected[: {error_msg}|: {reason}]"):
    """A goal is rejected."""

    robot: RobotName
    action: ActionName
    goal_id: Annotated[str, Field(description="The goal's id, as it was sent.")]
    reason: Annotated[str, Field(description="The reason as an identifier, such as `not_ready`.")]
    error_msg: Annotated[str, Field(description="The reason as text.")]


EVENTS: Final = EventGroup("goals", (GoalAccepted, GoalStatusChanged, SendGoalRejected))
