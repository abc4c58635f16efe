"""Planning through several poses without driving."""

from __future__ import annotations

import math

import pytest

from hmrsim.geometry import yaw_of
from hmrsim.interfaces.nav2_msgs import ComputePathThroughPoses
from hmrsim.protocol.commands import SendGoal

A = "a" * 32


def at(x, y, yaw=0.0):
    """Return a pose in plain values."""
    orientation = {"z": math.sin(yaw / 2), "w": math.cos(yaw / 2)}
    return {"pose": {"position": {"x": float(x), "y": float(y)}, "orientation": orientation}}


def compute(*goals, **fields):
    """Return the command to plan."""
    message = ComputePathThroughPoses.Goal.model_validate({"goals": {"goals": [*goals]}, **fields})
    return SendGoal("wall_e", "compute_path_through_poses", message, A, A)


def path_of(log):
    """Return the poses of the path that was found."""
    return [
        (p.pose.position.x, p.pose.position.y, round(yaw_of(p.pose.orientation.z, p.pose.orientation.w), 6))
        for p in log.result(A).path.poses
    ]


def test_the_parts_are_joined_at_the_goals(run):
    """There and back: where two parts meet there is one pose, that of the goal."""
    log = run((0.0, compute(at(5, 2), at(9, 2, 1.0), at(5, 2, 2.0))))

    assert [(1.0, 2.0, 0.0), (5.0, 2.0, 0.0), (9.0, 2.0, 1.0), (5.0, 2.0, 2.0)] == path_of(log)
    assert (0, "SUCCEEDED") == log.changes(A)[-1]
    assert -1 == log.result(A).last_reached_index


def test_a_goal_in_the_place_of_the_one_before_counts_in_its_stead(run):
    """No way leads there, but the robot is to face as the later one says."""
    assert [(1.0, 2.0, 0.0), (5.0, 2.0, 1.0)] == path_of(run((0.0, compute(at(5, 2), at(5, 2, 1.0)))))


def test_it_begins_at_the_start_if_that_is_to_be_used(run):
    """And at the robot otherwise."""
    log = run((0.0, compute(at(5, 2), start=at(9, 2), use_start=True)))

    assert [(9.0, 2.0, 3.141593), (5.0, 2.0, 0.0)] == path_of(log)


@pytest.mark.parametrize(
    ("goals", "fields", "code", "text"),
    [
        ([], {}, 309, "there are no poses"),
        ([at(5, 2)], {"start": at(-1, 2), "use_start": True}, 303, "pose 0: start (-1, 2) is outside the map"),
        ([at(5, 2), at(21, 2)], {}, 304, "pose 1: target (21, 2) is outside the map"),
        ([at(5, 2)], {"start": at(7, 5), "use_start": True}, 305, "pose 0: start (7, 5) is inside an obstacle"),
        ([at(7, 5), at(5, 2)], {}, 306, "pose 0: target (7, 5) is inside an obstacle"),
        ([at(5, 2), at(9, 2), at(15, 2)], {}, 308, "pose 2: no route from (9, 2) to (15, 2)"),
    ],
)
def test_where_there_is_no_path_it_says_which_pose_is_at_fault(run, goals, fields, code, text):
    """ABORTED at once, with Nav2's code; there is no path to some of them."""
    log = run((1.0, compute(*goals, **fields)))

    assert (1.0, "ABORTED") == log.changes(A)[-1]
    assert code == log.result(A).error_code
    assert log.result(A).error_msg.startswith(text)
    assert [] == path_of(log)


def test_an_unknown_planner_is_not_asked(run):
    """The goal is rejected."""
    answer = run((0.0, compute(at(5, 2), planner_id="hybrid"))).answer(A)

    assert (False, "invalid_goal") == (answer.accepted, answer.reason)
