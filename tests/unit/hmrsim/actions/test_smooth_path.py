"""Smoothing of paths: what is left to do where robots turn on the spot."""

from __future__ import annotations

import math

import pytest

from hmrsim.geometry import yaw_of
from hmrsim.interfaces.nav2_msgs import SmoothPath
from hmrsim.protocol.commands import SendGoal

A = "a" * 32


def smooth(*points, yaw=0.0, **fields):
    """Return the command to smooth a path whose poses all face the same way."""
    orientation = {"z": math.sin(yaw / 2), "w": math.cos(yaw / 2)}
    poses = [{"pose": {"position": {"x": float(x), "y": float(y)}, "orientation": orientation}} for x, y in points]
    return SendGoal("wall_e", "smooth_path", SmoothPath.Goal.model_validate({"path": {"poses": poses}, **fields}), A, A)


def path_of(log):
    """Return the poses of the smoothed path."""
    return [
        (p.pose.position.x, p.pose.position.y, round(yaw_of(p.pose.orientation.z, p.pose.orientation.w), 4))
        for p in log.result(A).path.poses
    ]


def test_corners_stay_and_poses_face_the_way_that_goes_on(run):
    """The last one faces as it did."""
    log = run((0.0, smooth((1, 2), (5, 2), (5, 4), yaw=1.0)))

    assert [(1.0, 2.0, 0.0), (5.0, 2.0, 1.5708), (5.0, 4.0, 1.0)] == path_of(log)
    assert log.result(A).was_completed


def test_a_pose_in_the_place_of_the_one_before_is_left_out(run):
    """As where two paths were joined."""
    log = run((0.0, smooth((1, 2), (5, 2), (5, 2), (9, 2), smoother_id="route_smoother")))

    assert [(1.0, 2.0), (5.0, 2.0), (9.0, 2.0)] == [(x, y) for x, y, _ in path_of(log)]


def test_a_path_into_an_obstacle_is_found_if_it_is_looked_for(run):
    """ABORTED with 503, and what is in the way."""
    log = run((0.0, smooth((1, 2), (13, 2), check_for_collisions=True)))

    assert (503, "ABORTED") == (log.result(A).error_code, log.changes(A)[-1][1])
    assert "blocked: an obstacle stands between (1, 2) and (13, 2)" == log.result(A).error_msg


def test_it_does_not_look_otherwise(run):
    """As Nav2's smoother does not."""
    assert "SUCCEEDED" == run((0.0, smooth((1, 2), (13, 2)))).changes(A)[-1][1]


@pytest.mark.parametrize("x", [2e7, 1e300])
def test_a_path_that_leads_beyond_all_maps_is_invalid(run, x):
    """ABORTED with 505."""
    assert 505 == run((0.0, smooth((1, 2), (x, 2)))).result(A).error_code


@pytest.mark.parametrize(
    ("points", "smoother", "text"),
    [
        ([], "", "the path has no poses"),
        ([(1, 2)], "best", "no smoother 'best'; there is one, called simple_smoother, route_smoother"),
    ],
)
def test_what_can_not_be_smoothed_is_rejected(run, points, smoother, text):
    """No path, or by an unknown smoother."""
    answer = run((0.0, smooth(*points, smoother_id=smoother))).answer(A)

    assert (False, "invalid_goal", text) == (answer.accepted, answer.reason, answer.error_msg)
