"""Planning a path to one or several poses without driving."""

from __future__ import annotations

import pytest

from hmrsim.geometry import yaw_of
from tests.simulation import A, B, at, send


def compute(goal, goal_id=A, **fields):
    return send("compute_path_to_pose", goal_id, goal=goal, **fields)


def through(*goals, **fields):
    return send("compute_path_through_poses", goals={"goals": goals}, **fields)


def path_of(log):
    return [
        (p.pose.position.x, p.pose.position.y, round(yaw_of(p.pose.orientation.z, p.pose.orientation.w), 6))
        for p in log.result(A).path.poses
    ]


def test_the_path_follows_the_lanes_and_ends_at_the_goal(run):
    log = run((2.0, compute(at(9.0, 2.4, 1.0))))

    assert [(1.0, 2.0, 0.0), (5.0, 2.0, 0.0), (9.0, 2.0, 1.570796), (9.0, 2.4, 1.0)] == path_of(log)
    assert (2.0, "SUCCEEDED") == log.changes(A)[-1]
    assert "map" == log.result(A).path.header.frame_id
    assert (1.0, 2.0) == run.simulator.robots["wall_e"].pose().point


def test_it_begins_at_the_start_only_if_use_start_is_set(run):
    log = run((0.0, compute(at(5, 2), start=at(9, 2), use_start=True)))

    assert [(9.0, 2.0, 3.141593), (5.0, 2.0, 0.0)] == path_of(log)


def test_a_path_to_the_robot_s_own_pose_has_one_pose(run):
    assert [(1.0, 2.0, 0.5)] == path_of(run((0.0, compute(at(1, 2, 0.5)))))


def test_planning_does_not_interrupt_a_drive(run):

    log = run((0.0, send("follow_path", B, path={"poses": [at(5, 2)]})), (2.0, compute(at(9, 2))))

    assert (4.0, "SUCCEEDED") == log.changes(B)[-1]
    assert (3.0, 2.0, 0.0) == path_of(log)[0]


@pytest.mark.parametrize(
    ("goal", "fields", "code", "text"),
    [
        (at(5, 2), {"start": at(-1, 2), "use_start": True}, 203, "start (-1, 2) is outside the map"),
        (at(21, 2), {}, 204, "target (21, 2) is outside the map"),
        (at(5, 2), {"start": at(7, 5), "use_start": True}, 205, "start (7, 5) is inside an obstacle"),
        (at(7, 5), {}, 206, "target (7, 5) is inside an obstacle"),
        (at(15, 2), {}, 208, "no route from home to island"),
    ],
)
def test_without_a_path_the_error_has_the_planner_s_code(run, goal, fields, code, text):
    log = run((1.0, compute(goal, **fields)))

    assert (1.0, "ABORTED") == log.changes(A)[-1]
    assert code == log.result(A).error_code
    assert log.result(A).error_msg.startswith(text)


def test_an_unknown_planner_is_rejected(run):
    answer = run((0.0, compute(at(5, 2), planner_id="hybrid"))).answer(A)

    assert (False, "invalid_goal", 1) == (answer.accepted, answer.reason, answer.error_code)
    assert "no planner 'hybrid'; there is one, called graph, GridBased" == answer.error_msg


def test_a_start_in_an_unknown_frame_matters_only_if_it_is_used(run):
    start = {"header": {"frame_id": "odom"}}
    log = run((0.0, compute(at(5, 2), start=start, use_start=True)), (0.0, compute(at(5, 2), B, start=start)))

    assert (False, "invalid_goal") == (log.answer(A).accepted, log.answer(A).reason)
    assert log.answer(B).accepted


def test_the_parts_are_joined_at_the_goals(run):
    log = run((0.0, through(at(5, 2), at(9, 2, 1.0), at(5, 2, 2.0))))

    assert [(1.0, 2.0, 0.0), (5.0, 2.0, 0.0), (9.0, 2.0, 1.0), (5.0, 2.0, 2.0)] == path_of(log)
    assert (0, "SUCCEEDED") == log.changes(A)[-1]
    assert -1 == log.result(A).last_reached_index


def test_a_goal_at_the_previous_pose_replaces_it(run):
    """No route leads between equal positions, but the robot must face as the later goal says."""
    assert [(1.0, 2.0, 0.0), (5.0, 2.0, 1.0)] == path_of(run((0.0, through(at(5, 2), at(5, 2, 1.0)))))


def test_a_path_through_poses_begins_at_the_start_only_if_use_start_is_set(run):
    log = run((0.0, through(at(5, 2), start=at(9, 2), use_start=True)))

    assert [(9.0, 2.0, 3.141593), (5.0, 2.0, 0.0)] == path_of(log)


@pytest.mark.parametrize(
    ("goals", "fields", "code", "text"),
    [
        ([], {}, 309, "there are no poses"),
        ([at(5, 2)], {"start": at(-1, 2), "use_start": True}, 303, "pose 0: start (-1, 2) is outside the map"),
        ([at(5, 2), at(21, 2)], {}, 304, "pose 1: target (21, 2) is outside the map"),
        ([at(5, 2)], {"start": at(7, 5), "use_start": True}, 305, "pose 0: start (7, 5) is inside an obstacle"),
        ([at(7, 5), at(5, 2)], {}, 306, "pose 0: target (7, 5) is inside an obstacle"),
        ([at(5, 2), at(9, 2), at(15, 2)], {}, 308, "pose 2: no route from shelf to island"),
    ],
)
def test_without_a_path_the_error_names_the_pose(run, goals, fields, code, text):
    log = run((1.0, through(*goals, **fields)))

    assert (1.0, "ABORTED") == log.changes(A)[-1]
    assert code == log.result(A).error_code
    assert log.result(A).error_msg.startswith(text)
    assert [] == path_of(log)


def test_an_unknown_planner_of_a_path_through_poses_is_rejected(run):
    answer = run((0.0, through(at(5, 2), planner_id="hybrid"))).answer(A)

    assert (False, "invalid_goal") == (answer.accepted, answer.reason)
