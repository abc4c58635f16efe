"""Planning without driving."""

from __future__ import annotations

import math

import pytest

from hmrsim.geometry import yaw_of
from hmrsim.interfaces.nav2_msgs import ComputePathToPose, FollowPath
from hmrsim.protocol.commands import SendGoal

A, B = "a" * 32, "b" * 32


def at(x, y, yaw=0.0):
    """Return a pose in plain values."""
    orientation = {"z": math.sin(yaw / 2), "w": math.cos(yaw / 2)}
    return {"pose": {"position": {"x": float(x), "y": float(y)}, "orientation": orientation}}


def compute(goal, goal_id=A, **fields):
    """Return the command to plan."""
    message = ComputePathToPose.Goal.model_validate({"goal": goal, **fields})
    return SendGoal("wall_e", "compute_path_to_pose", message, goal_id, goal_id)


def path_of(log):
    """Return the poses of the path that was found."""
    return [
        (p.pose.position.x, p.pose.position.y, round(yaw_of(p.pose.orientation.z, p.pose.orientation.w), 6))
        for p in log.result(A).path.poses
    ]


def test_the_path_leads_along_the_lanes_and_ends_as_the_goal_says(run):
    """From where the robot is, up to the point nearest to the goal; each pose faces the way that goes on from there."""
    log = run((2.0, compute(at(9.0, 2.4, 1.0))))

    assert [(1.0, 2.0, 0.0), (5.0, 2.0, 0.0), (9.0, 2.0, 1.570796), (9.0, 2.4, 1.0)] == path_of(log)
    assert (2.0, "SUCCEEDED") == log.changes(A)[-1]
    assert "map" == log.result(A).path.header.frame_id
    assert (1.0, 2.0) == run.simulator.robots["wall_e"].pose().point


def test_it_begins_at_the_start_if_that_is_to_be_used(run):
    """And at the robot otherwise, whatever the start says."""
    log = run((0.0, compute(at(5, 2), start=at(9, 2), use_start=True)))

    assert [(9.0, 2.0, 3.141593), (5.0, 2.0, 0.0)] == path_of(log)


def test_a_path_to_where_it_is_has_one_pose(run):
    """The goal's."""
    assert [(1.0, 2.0, 0.5)] == path_of(run((0.0, compute(at(1, 2, 0.5)))))


def test_a_drive_goes_on_while_it_plans(run):
    """It does not hold the base."""
    follow = FollowPath.Goal.model_validate({"path": {"poses": [at(5, 2)]}})

    log = run(
        (0.0, SendGoal("wall_e", "follow_path", follow, B)),
        (2.0, compute(at(9, 2))),
    )

    assert (4.0, "SUCCEEDED") == log.changes(B)[-1]
    assert (3.0, 2.0, 0.0) == path_of(log)[0]


@pytest.mark.parametrize(
    ("goal", "fields", "code", "text"),
    [
        (at(5, 2), {"start": at(-1, 2), "use_start": True}, 203, "start (-1, 2) is outside the map"),
        (at(21, 2), {}, 204, "target (21, 2) is outside the map"),
        (at(5, 2), {"start": at(7, 5), "use_start": True}, 205, "start (7, 5) is inside an obstacle"),
        (at(7, 5), {}, 206, "target (7, 5) is inside an obstacle"),
        (at(15, 2), {}, 208, "no route from (1, 2) to (15, 2)"),
    ],
)
def test_where_there_is_no_path_it_says_why(run, goal, fields, code, text):
    """ABORTED at once, with the planner's code."""
    log = run((1.0, compute(goal, **fields)))

    assert (1.0, "ABORTED") == log.changes(A)[-1]
    assert code == log.result(A).error_code
    assert log.result(A).error_msg.startswith(text)


def test_an_unknown_planner_is_not_asked(run):
    """The goal is rejected, and says who there is."""
    answer = run((0.0, compute(at(5, 2), planner_id="hybrid"))).answer(A)

    assert (False, "invalid_goal", 1) == (answer.accepted, answer.reason, answer.error_code)
    assert "no planner 'hybrid'; there is one, called graph, GridBased" == answer.error_msg


def test_a_start_in_an_unknown_frame_matters_only_if_it_is_used(run):
    """Rejected, or planned from the robot."""
    start = {"header": {"frame_id": "odom"}}
    log = run((0.0, compute(at(5, 2), start=start, use_start=True)), (0.0, compute(at(5, 2), B, start=start)))

    assert (False, "invalid_goal") == (log.answer(A).accepted, log.answer(A).reason)
    assert log.answer(B).accepted
