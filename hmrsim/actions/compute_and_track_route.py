"""Find the quickest route on the graph, and tell how the robot gets on along it, whatever drives it."""

from __future__ import annotations

from collections.abc import Generator
from typing import TYPE_CHECKING, Any

from hmrsim.actions import Action, Codes, Report
from hmrsim.actions._route_tracking import RouteTracker
from hmrsim.actions._routes import INPUTS, frames_of
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.nav2_msgs import ComputeAndTrackRoute

if TYPE_CHECKING:
    from hmrsim.robots.robot import Robot


def _process(
    robot: Robot, goal: ComputeAndTrackRoute.Goal, report: Report[ComputeAndTrackRoute.Feedback]
) -> Generator[Any, Any, ComputeAndTrackRoute.Result]:
    began = robot.now
    yield from RouteTracker(robot, goal, report).track()
    return ComputeAndTrackRoute.Result(execution_duration=Duration.from_seconds(robot.now - began))


ACTION = Action(
    name="compute_and_track_route",
    goal=ComputeAndTrackRoute.Goal,
    result=ComputeAndTrackRoute.Result,
    feedback=ComputeAndTrackRoute.Feedback,
    process=_process,
    failure=lambda code, message: ComputeAndTrackRoute.Result(error_code=code, error_msg=message),
    codes=Codes.of_nav2(ComputeAndTrackRoute.Result),
    holds_base=False,
    exclusive=True,
    frames=frames_of,
    inputs=INPUTS,
    example={"use_poses": True, "goal": {"pose": {"position": {"x": 0.5}}}},
)
