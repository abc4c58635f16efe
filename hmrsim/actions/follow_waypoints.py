"""Drive to poses one by one, along the lanes, and go on when one can't be reached."""

from __future__ import annotations

from collections.abc import Generator
from typing import TYPE_CHECKING, Any

from hmrsim.actions import FRAMES, Action, Codes, Order, Report, unknown_frame
from hmrsim.actions._inputs import Input, places
from hmrsim.actions._navigation import drive, facing, no_planner, plan
from hmrsim.errors import GoalAborted
from hmrsim.interfaces.nav2_msgs import FollowWaypoints, NavigateToPose, WaypointStatus

if TYPE_CHECKING:
    from hmrsim.robots.robot import Robot
    from hmrsim.world.model import World


class _Round:
    """The progress of a robot through its poses, and those that it has missed."""

    def __init__(self, robot: Robot, goal: FollowWaypoints.Goal, report: Report[FollowWaypoints.Feedback]) -> None:
        self._robot = robot
        self._poses = goal.poses
        self._at = goal.goal_index
        self._missed: list[WaypointStatus] = []
        report.on_failure(self.result)
        report.sample(lambda: {"current_waypoint": self._at})

    def make(self, first: int) -> Generator[Any, Any, None]:
        """Drive to each pose, from that of the index *first* on."""
        for index, pose in enumerate(self._poses[first:], start=first):
            self._at = index
            try:
                if pose.header.frame_id not in FRAMES:
                    raise GoalAborted(NavigateToPose.Result.TF_ERROR, unknown_frame(pose.header.frame_id))  # noqa: TRY301
                way = yield from plan(self._robot, pose)
                yield from drive(self._robot, way, facing(pose))
            except GoalAborted as missed:
                self._missed.append(
                    WaypointStatus(
                        waypoint_status=WaypointStatus.FAILED,
                        waypoint_index=index,
                        waypoint_pose=pose,
                        error_code=missed.code,
                        error_msg=str(missed),
                    )
                )

    def result(self, code: int = 0, message: str = "") -> FollowWaypoints.Result:
        """Return the result as it would be now."""
        return FollowWaypoints.Result(missed_waypoints=self._missed, error_code=code, error_msg=message)


def _process(
    robot: Robot, goal: FollowWaypoints.Goal, report: Report[FollowWaypoints.Feedback]
) -> Generator[Any, Any, FollowWaypoints.Result]:
    there = len(goal.poses)
    if goal.goal_index >= there:
        text = f"goal_index {goal.goal_index} of {there} poses; the first is 0" if there else "there are no poses"
        raise GoalAborted(FollowWaypoints.Result.NO_VALID_WAYPOINTS, text)
    rounds = _Round(robot, goal, report)
    yield from rounds.make(goal.goal_index)
    for _ in range(goal.number_of_loops):
        began = robot.now
        yield from rounds.make(0)
        if robot.now == began:
            # Another loop would take no time either, and there may be billions of them.
            break
    return rounds.result()


def _ordered(text: str, world: World) -> FollowWaypoints.Goal:
    return FollowWaypoints.Goal(poses=places(text, world))


ACTION = Action(
    name="follow_waypoints",
    goal=FollowWaypoints.Goal,
    result=FollowWaypoints.Result,
    feedback=FollowWaypoints.Feedback,
    process=_process,
    failure=lambda code, message: FollowWaypoints.Result(error_code=code, error_msg=message),
    codes=Codes.of_nav2(FollowWaypoints.Result),
    frames=lambda goal: (at.header.frame_id for at in goal.poses),
    not_ready=no_planner,
    skips_frames=True,
    order=Order("Visit", "PLACE; PLACE; …", _ordered),
    inputs={
        "poses": Input("Waypoints", required=True),
        "number_of_loops": Input("Further loops", advanced=True),
        "goal_index": Input("Index of the first waypoint", advanced=True),
    },
    example={"poses": [{"pose": {"position": {"x": 4.0}}}, {"pose": {"position": {"x": 10.0}}}]},
)
