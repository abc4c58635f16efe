"""Find the quickest route on the graph without driving it."""

from __future__ import annotations

from collections.abc import Generator
from typing import TYPE_CHECKING, Any

from hmrsim.actions import Action, Codes, Report
from hmrsim.actions._navigation import path_message
from hmrsim.actions._routes import INPUTS, ends_of, find_route, frames_of, poses_on, route_values
from hmrsim.interfaces.nav2_msgs import ComputeRoute, Route

if TYPE_CHECKING:
    from hmrsim.robots.robot import Robot


def _process(
    robot: Robot, goal: ComputeRoute.Goal, _report: Report[ComputeRoute.Feedback]
) -> Generator[Any, Any, ComputeRoute.Result]:
    yield from ()
    route = find_route(robot, ends_of(robot, goal))
    path = path_message(robot, poses_on(robot, route))
    return ComputeRoute.Result(path=path, route=Route.model_validate(route_values(robot, route)))


ACTION = Action(
    name="compute_route",
    goal=ComputeRoute.Goal,
    result=ComputeRoute.Result,
    feedback=ComputeRoute.Feedback,
    process=_process,
    failure=lambda code, message: ComputeRoute.Result(error_code=code, error_msg=message),
    codes=Codes.of_nav2(ComputeRoute.Result),
    holds_base=False,
    frames=frames_of,
    inputs=INPUTS,
    example={"use_poses": True, "goal": {"pose": {"position": {"x": 10.0}}}},
)
