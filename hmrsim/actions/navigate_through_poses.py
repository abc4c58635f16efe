"""Drive through poses to the last one, along the lanes."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from hmrsim.actions import Action, Codes, Order, Report
from hmrsim.actions._inputs import Input, places
from hmrsim.actions._navigation import drive, extent, facing, navigation_of, no_planner, plan
from hmrsim.errors import GoalAborted
from hmrsim.interfaces.nav2_msgs import NavigateThroughPoses, WaypointStatus
from hmrsim.interfaces.nav_msgs import Goals

if TYPE_CHECKING:
    from hmrsim.actions._navigation import Way
    from hmrsim.interfaces.geometry_msgs import PoseStamped
    from hmrsim.robots.robot import Robot
    from hmrsim.world.model import World


class _Tour:
    """The progress of a robot through some poses."""

    def __init__(self, robot: Robot, poses: Sequence[PoseStamped]) -> None:
        self._robot = robot
        self._poses = poses
        self._plain = [at.model_dump() for at in poses]
        self._telling = navigation_of(robot, self._left)
        self._done = 0
        self._next = 0
        self._ahead: list[tuple[float, float]] = []

    def make(self) -> Generator[Any, Any, None]:
        """Plan the ways to all poses, then drive them."""
        ways: list[Way] = []
        start = None
        for pose in self._poses:
            ways.append((yield from plan(self._robot, pose, start)))
            start = pose
            self._next += 1
        self._next = 0
        self._ahead = [extent(self._robot, way) for way in ways]
        for pose, way in zip(self._poses, ways, strict=True):
            del self._ahead[0]
            yield from drive(self._robot, way, None if self._ahead else facing(pose))
            self._done = self._next = self._done + 1

    def _left(self) -> tuple[float, float]:
        return sum(length for length, _ in self._ahead), sum(seconds for _, seconds in self._ahead)

    def statuses(self, code: int = 0, message: str = "") -> list[dict[str, Any]]:
        """Return the status of each pose; with a code, the current one has failed."""
        statuses: list[dict[str, Any]] = [
            {
                "waypoint_status": WaypointStatus.COMPLETED if i < self._done else WaypointStatus.PENDING,
                "waypoint_index": i,
                "waypoint_pose": pose,
                "error_code": 0,
                "error_msg": "",
            }
            for i, pose in enumerate(self._plain)
        ]
        if code and self._next < len(statuses):
            statuses[self._next] |= {"waypoint_status": WaypointStatus.FAILED, "error_code": code, "error_msg": message}
        return statuses

    def feedback(self) -> dict[str, Any]:
        """Return the feedback: the remaining part of the way."""
        return {
            **self._telling(),
            "number_of_poses_remaining": len(self._poses) - self._done,
            "waypoint_statuses": self.statuses(),
        }

    def result(self, code: int = 0, message: str = "") -> NavigateThroughPoses.Result:
        """Return the result."""
        fields = {"error_code": code, "error_msg": message, "waypoint_statuses": self.statuses(code, message)}
        return NavigateThroughPoses.Result.model_validate(fields)


def _process(
    robot: Robot, goal: NavigateThroughPoses.Goal, report: Report[NavigateThroughPoses.Feedback]
) -> Generator[Any, Any, NavigateThroughPoses.Result]:
    if not goal.poses.goals:
        raise GoalAborted(NavigateThroughPoses.Result.UNKNOWN, "there are no poses; give one at least")
    tour = _Tour(robot, goal.poses.goals)
    report.on_failure(tour.result)
    report.sample(tour.feedback)
    yield from tour.make()
    return tour.result()


def _frames(goal: NavigateThroughPoses.Goal) -> Iterator[str]:
    yield goal.poses.header.frame_id
    yield from (at.header.frame_id for at in goal.poses.goals)


def _ordered(text: str, world: World) -> NavigateThroughPoses.Goal:
    return NavigateThroughPoses.Goal(poses=Goals(goals=places(text, world)))


ACTION = Action(
    name="navigate_through_poses",
    goal=NavigateThroughPoses.Goal,
    result=NavigateThroughPoses.Result,
    feedback=NavigateThroughPoses.Feedback,
    process=_process,
    failure=lambda code, message: NavigateThroughPoses.Result(error_code=code, error_msg=message),
    codes=Codes.of_nav2(NavigateThroughPoses.Result),
    frames=_frames,
    not_ready=no_planner,
    rejects_early={"frames"},
    order=Order("Through", "PLACE; PLACE; …", _ordered),
    inputs={"poses.goals": Input("Poses", required=True)},
    example={"poses": {"goals": [{"pose": {"position": {"x": 4.0}}}, {"pose": {"position": {"x": 10.0}}}]}},
)
