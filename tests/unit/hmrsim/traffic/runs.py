"""Runs of robots under a policy."""

from __future__ import annotations

from hmrsim.interfaces.geometry_msgs import Point, Pose, PoseStamped
from hmrsim.interfaces.nav2_msgs import NavigateToPose
from hmrsim.protocol.commands import SendGoal
from tests.simulation import simulate


def go(robot, x, y, goal_id):
    """Return the command that sends a robot to a point."""
    pose = PoseStamped(pose=Pose(position=Point(x=float(x), y=float(y))))
    return SendGoal(robot, "navigate_to_pose", NavigateToPose.Goal(pose=pose), goal_id)


def under(policy, world, **settings):
    """Return a simulation of a world under a policy."""
    return simulate({**world, "traffic": {"policy": policy, **settings}})


def end(log, goal_id):
    """Return when a goal ended, rounded to a microsecond, its status and its message."""
    at, status = log.changes(goal_id)[-1]
    return round(at, 6), status, log.result(goal_id).error_msg
