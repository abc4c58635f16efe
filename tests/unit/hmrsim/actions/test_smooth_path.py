"""Smoothing of paths for robots that turn in place."""

from __future__ import annotations

import pytest

from hmrsim.geometry import yaw_of
from tests.simulation import A, at, send


def smooth(*points, yaw=0.0, **fields):
    return send("smooth_path", path={"poses": [at(*point, yaw) for point in points]}, **fields)


def path_of(log):
    return [
        (p.pose.position.x, p.pose.position.y, round(yaw_of(p.pose.orientation.z, p.pose.orientation.w), 4))
        for p in log.result(A).path.poses
    ]


def test_corners_stay_and_poses_face_the_next_segment(run):
    log = run((0.0, smooth((1, 2), (5, 2), (5, 4), yaw=1.0)))

    assert [(1.0, 2.0, 0.0), (5.0, 2.0, 1.5708), (5.0, 4.0, 1.0)] == path_of(log)
    assert log.result(A).was_completed


def test_duplicate_poses_are_left_out(run):
    log = run((0.0, smooth((1, 2), (5, 2), (5, 2), (9, 2), smoother_id="route_smoother")))

    assert [(1.0, 2.0), (5.0, 2.0), (9.0, 2.0)] == [(x, y) for x, y, _ in path_of(log)]


def test_a_collision_is_reported_on_request(run):
    log = run((0.0, smooth((1, 2), (13, 2), check_for_collisions=True)))

    assert (503, "ABORTED") == (log.result(A).error_code, log.changes(A)[-1][1])
    assert "blocked: an obstacle stands between (1, 2) and (13, 2)" == log.result(A).error_msg


def test_collisions_are_ignored_by_default(run):
    assert "SUCCEEDED" == run((0.0, smooth((1, 2), (13, 2)))).changes(A)[-1][1]


@pytest.mark.parametrize("x", [2e7, 1e300])
def test_a_path_beyond_all_maps_is_invalid(run, x):
    assert 505 == run((0.0, smooth((1, 2), (x, 2)))).result(A).error_code


@pytest.mark.parametrize(
    ("points", "smoother", "text"),
    [
        ([], "", "the path has no poses"),
        ([(1, 2)], "best", "no smoother 'best'; there is one, called simple_smoother, route_smoother"),
    ],
)
def test_empty_paths_and_unknown_smoothers_are_rejected(run, points, smoother, text):
    answer = run((0.0, smooth(*points, smoother_id=smoother))).answer(A)

    assert (False, "invalid_goal", text) == (answer.accepted, answer.reason, answer.error_msg)
