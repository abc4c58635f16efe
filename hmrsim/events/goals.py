"""Events of goals: accepted, changed, ended, rejected."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Final

from pydantic import Field

from hmrsim.events._event import ActionName, Event, EventGroup, GoalId, Part, RobotName, Whole


class GoalAccepted(Event, kind="goal", text="{action} accepted[: {goal:goal}]", traced=False, changes=Part.GOALS):
    """An action server accepts a goal; its status changes next."""

    robot: RobotName
    action: ActionName
    goal_id: GoalId
    goal: Annotated[
        Mapping[str, Any] | None,
        Field(description="The action's goal message; fields with ROS's default are omitted."),
    ]


class GoalStatusChanged(
    Event,
    kind="status",
    severity="[{status=6}error|{status=5}warning|{status=4}info|debug]",
    text="{action} [{status=1}ACCEPTED|{status=2}EXECUTING|{status=3}CANCELING|{status=4}SUCCEEDED|{status=5}CANCELED|"
    "{status=6}ABORTED|status {status}][{status=6}: {result:error}]",
    changes=Part.GOALS,
):
    """The status of a goal changes."""

    robot: RobotName
    action: ActionName
    goal_id: GoalId
    status: Annotated[
        Whole, Field(description="The status, as in action_msgs/msg/GoalStatus; 4, 5 and 6 are terminal.")
    ]
    result: Annotated[
        Mapping[str, Any] | None, Field(description="The action's result message, of a goal that has ended.")
    ] = None
    cause: Annotated[
        str | None, Field(description="Why it did not succeed, as an identifier, such as `preempted`.")
    ] = None


class SendGoalRejected(Event, kind="rejected", severity="warning", text="{action} rejected[: {error_msg}|: {reason}]"):
    """An action server rejects a goal."""

    robot: RobotName
    action: ActionName
    goal_id: Annotated[str, Field(description="The goal's id, as sent.")]
    reason: Annotated[str, Field(description="The reason as an identifier, such as `not_ready`.")]
    error_msg: Annotated[str, Field(description="The reason as text.")]


EVENTS: Final = EventGroup("goals", (GoalAccepted, GoalStatusChanged, SendGoalRejected))
