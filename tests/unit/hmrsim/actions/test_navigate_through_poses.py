"""Driving through several poses with one goal."""

from __future__ import annotations

import pytest

from hmrsim.protocol.commands import CancelGoal
from tests import simulation
from tests.simulation import A, B, send


def at(*pose, frame=""):
    return {**simulation.at(*pose), "header": {"frame_id": frame}}


def through(*poses, goal_id=A):
    return send("navigate_through_poses", goal_id, poses={"goals": poses})


def statuses(message):
    return [each.waypoint_status for each in message.waypoint_statuses]


def test_it_passes_all_poses_and_ends_with_the_last_yaw(run):
    log = run((1.0, through(at(9, 2, 3.0), at(5, 2, 1.0))))

    assert (13.0, "SUCCEEDED") == log.changes(A)[-1]
    assert (5.0, 2.0, 1.0) == pytest.approx(run.simulator.robots["wall_e"].pose())
    assert 0 == log.result(A).error_code
    assert [1, 1] == statuses(log.result(A))
    assert [0, 1] == [each.waypoint_index for each in log.result(A).waypoint_statuses]


def test_each_pose_is_reached_before_the_next(run):
    run((0.0, through(at(9, 2), at(5, 2))), until=9.0)

    assert (8.0, 2.0) == run.simulator.robots["wall_e"].pose().point


def test_feedback_covers_all_remaining_poses(run):
    log = run((0.0, through(at(9, 2), at(5, 2))))
    reported = {round(time, 6): feedback for time, feedback in log.feedback(A)}

    assert (10.0, 3.0) == pytest.approx((reported[2.0].distance_remaining, reported[9.0].distance_remaining))
    assert (10.0, 3.0) == pytest.approx([reported[time].estimated_time_remaining.to_seconds() for time in (2.0, 9.0)])
    assert [2, 1, 0] == [reported[time].number_of_poses_remaining for time in (2.0, 9.0, 12.0)]
    assert [[0, 0], [1, 0], [1, 1]] == [statuses(reported[time]) for time in (2.0, 9.0, 12.0)]
    assert 0.0 == reported[12.0].distance_remaining


def test_an_unreachable_pose_aborts_before_the_robot_moves(run):
    log = run((1.0, through(at(5, 2), at(7, 5), at(9, 2))))
    result = log.result(A)

    assert (1.0, "ABORTED") == log.changes(A)[-1]
    assert (206, "target (7, 5) is inside an obstacle") == (result.error_code, result.error_msg)
    assert [0, 3, 0] == statuses(result)
    assert 206 == result.waypoint_statuses[1].error_code
    assert (1.0, 2.0) == run.simulator.robots["wall_e"].pose().point


def test_without_poses_it_is_aborted(run):
    log = run((0.0, through()))

    assert (9100, "there are no poses; give one at least") == (log.result(A).error_code, log.result(A).error_msg)


def test_a_pose_in_an_unknown_frame_is_rejected(run):
    assert "invalid_goal" == run((0.0, through(at(5, 2), at(9, 2, frame="odom")))).answer(A).reason


@pytest.mark.parametrize(
    ("end", "status", "code", "poses"),
    [
        (CancelGoal("wall_e", "navigate_through_poses", A), "CANCELED", 0, [1, 0]),
        (through(at(1, 2), goal_id=B), "ABORTED", 9100, [1, 3]),
    ],
)
def test_a_canceled_or_preempted_goal_reports_each_pose(run, end, status, code, poses):
    log = run((0.0, through(at(5, 2), at(9, 2))), (5.0, end))

    assert (5.0, status) == log.changes(A)[-1]
    assert (code, poses) == (log.result(A).error_code, statuses(log.result(A)))


def test_poses_at_the_robot_are_reached_at_once(run):
    assert (0.0, "SUCCEEDED") == run((0.0, through(at(1, 2), at(1, 2)))).changes(A)[-1]
