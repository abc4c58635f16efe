"""Driving to waypoints one by one."""

from __future__ import annotations

import pytest

from hmrsim.protocol.commands import CancelGoal
from tests.simulation import A, at, send

HOME, DOOR, SHELF, SOLID = (1, 2), (5, 2), (9, 2), (7, 5)


def follow(*points, **fields):
    return send("follow_waypoints", poses=[at(*point) for point in points], **fields)


def missed(result):
    return [(w.waypoint_index, w.waypoint_status, w.error_code, w.error_msg) for w in result.missed_waypoints]


def test_it_drives_to_each_waypoint(run):
    log = run((0.0, follow(SHELF, DOOR)))
    current = {round(at, 6): feedback.current_waypoint for at, feedback in log.feedback(A)}

    assert (12.0, "SUCCEEDED") == log.changes(A)[-1]
    assert (0, []) == (log.result(A).error_code, log.result(A).missed_waypoints)
    assert [0, 1] == [current[7.0], current[9.0]]


def test_it_continues_after_an_unreachable_waypoint(run):
    log = run((0.0, follow(SOLID, DOOR)))

    assert (4.0, "SUCCEEDED") == log.changes(A)[-1]
    assert [(0, 3, 206, "target (7, 5) is inside an obstacle")] == missed(log.result(A))
    assert 7.0 == log.result(A).missed_waypoints[0].waypoint_pose.pose.position.x


@pytest.mark.parametrize(("loops", "seconds"), [(0, 8.0), (1, 16.0), (2, 24.0)])
def test_it_repeats_the_loop(run, loops, seconds):
    assert (seconds, "SUCCEEDED") == run((0.0, follow(DOOR, HOME, number_of_loops=loops))).changes(A)[-1]


def test_only_the_first_loop_begins_at_the_index(run):
    log = run((0.0, follow(SHELF, DOOR, HOME, goal_index=2, number_of_loops=1)))

    assert (16.0, "SUCCEEDED") == log.changes(A)[-1]


def test_billions_of_instant_loops_end_at_once(run):
    """If a loop takes no time, all further loops would be the same."""
    log = run((0.0, follow(HOME, SOLID, number_of_loops=2**32 - 1)))

    assert (0.0, "SUCCEEDED") == log.changes(A)[-1]
    assert [1, 1] == [index for index, *_ in missed(log.result(A))]


@pytest.mark.parametrize(
    ("command", "text"),
    [(follow(), "there are no poses"), (follow(DOOR, HOME, goal_index=2), "goal_index 2 of 2 poses; the first is 0")],
)
def test_without_waypoints_it_is_aborted(run, command, text):
    log = run((0.0, command))

    assert ("ABORTED", 602, text) == (log.changes(A)[-1][1], log.result(A).error_code, log.result(A).error_msg)


def test_a_canceled_goal_reports_missed_waypoints(run):
    log = run((0.0, follow(SOLID, SHELF)), (3.0, CancelGoal("wall_e", "follow_waypoints", A)))

    assert (3.0, "CANCELED") == log.changes(A)[-1]
    assert [0] == [index for index, *_ in missed(log.result(A))]
    assert (4.0, 2.0) == run.simulator.robots["wall_e"].pose().point
