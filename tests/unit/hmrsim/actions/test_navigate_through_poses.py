"""Driving through poses."""

from __future__ import annotations

import math

import pytest

from hmrsim.interfaces.nav2_msgs import NavigateThroughPoses
from hmrsim.protocol.commands import CancelGoal, SendGoal

A, B = "a" * 32, "b" * 32


def at(x, y, yaw=0.0, frame=""):
    """Return a pose in plain values."""
    orientation = {"z": math.sin(yaw / 2), "w": math.cos(yaw / 2)}
    pose = {"position": {"x": float(x), "y": float(y)}, "orientation": orientation}
    return {"header": {"frame_id": frame}, "pose": pose}


def through(*poses, goal_id=A):
    """Return the command to drive through poses."""
    goal = NavigateThroughPoses.Goal.model_validate({"poses": {"goals": list(poses)}})
    return SendGoal("wall_e", "navigate_through_poses", goal, goal_id, goal_id)


def statuses(message):
    """Return the status of each waypoint in a feedback or result."""
    return [each.waypoint_status for each in message.waypoint_statuses]


def test_it_passes_all_poses_in_order_and_faces_as_the_last_one_says(run):
    """Home to shelf, back to door: 8 m and 4 m at 1 m/s."""
    log = run((1.0, through(at(9, 2, 3.0), at(5, 2, 1.0))))

    assert (13.0, "SUCCEEDED") == log.changes(A)[-1]
    assert (5.0, 2.0, 1.0) == pytest.approx(run.simulator.robots["wall_e"].pose())
    assert (0, [1, 1], [0, 1]) == (
        log.result(A).error_code,
        statuses(log.result(A)),
        [each.waypoint_index for each in log.result(A).waypoint_statuses],
    )


def test_the_first_of_them_is_reached_before_the_second_is_driven_to(run):
    """It turns round at the shelf."""
    run((0.0, through(at(9, 2), at(5, 2))), until=9.0)

    assert (8.0, 2.0) == run.simulator.robots["wall_e"].pose().point


def test_feedback_is_about_all_that_is_left(run):
    """After 2 s of 12, and after 9."""
    log = run((0.0, through(at(9, 2), at(5, 2))))
    told = {round(time, 6): feedback for time, feedback in log.feedback(A)}

    assert (10.0, 3.0) == pytest.approx((told[2.0].distance_remaining, told[9.0].distance_remaining))
    assert (10.0, 3.0) == pytest.approx([told[time].estimated_time_remaining.to_seconds() for time in (2.0, 9.0)])
    assert [2, 1, 0] == [told[time].number_of_poses_remaining for time in (2.0, 9.0, 12.0)]
    assert [[0, 0], [1, 0], [1, 1]] == [statuses(told[time]) for time in (2.0, 9.0, 12.0)]
    assert 0.0 == told[12.0].distance_remaining


def test_nothing_is_driven_if_one_of_them_can_not_be_reached(run):
    """ABORTED with the planner's code, which the pose has, too."""
    log = run((1.0, through(at(5, 2), at(7, 5), at(9, 2))))
    result = log.result(A)

    assert (1.0, "ABORTED") == log.changes(A)[-1]
    assert (206, "target (7, 5) is inside an obstacle") == (result.error_code, result.error_msg)
    assert [0, 3, 0] == statuses(result)
    assert 206 == result.waypoint_statuses[1].error_code
    assert (1.0, 2.0) == run.simulator.robots["wall_e"].pose().point


def test_without_poses_it_is_aborted(run):
    """There is nothing to do, and that can't be meant."""
    log = run((0.0, through()))

    assert (9100, "there are no poses; give one at least") == (log.result(A).error_code, log.result(A).error_msg)


def test_a_pose_in_an_unknown_frame_is_rejected(run):
    """Any of them."""
    assert "invalid_goal" == run((0.0, through(at(5, 2), at(9, 2, frame="odom")))).answer(A).reason


def test_a_canceled_one_tells_how_far_it_came(run):
    """The first pose is behind, the second is not."""
    log = run((0.0, through(at(5, 2), at(9, 2))), (5.0, CancelGoal("wall_e", "navigate_through_poses", A)))

    assert (5.0, "CANCELED") == log.changes(A)[-1]
    assert (0, [1, 0]) == (log.result(A).error_code, statuses(log.result(A)))


def test_a_preempted_one_has_failed_where_it_was(run):
    """With the action's UNKNOWN."""
    log = run((0.0, through(at(5, 2), at(9, 2))), (5.0, through(at(1, 2), goal_id=B)))

    assert (9100, [1, 3]) == (log.result(A).error_code, statuses(log.result(A)))
    assert (5.0, "ABORTED") == log.changes(A)[-1]


def test_poses_where_it_is_are_reached_at_once(run):
    """No time passes."""
    assert (0.0, "SUCCEEDED") == run((0.0, through(at(1, 2), at(1, 2)))).changes(A)[-1]
