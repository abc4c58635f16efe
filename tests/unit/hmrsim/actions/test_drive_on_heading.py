"""Driving straight ahead and straight back."""

from __future__ import annotations

import math

import pytest

from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.geometry_msgs import Point
from hmrsim.interfaces.nav2_msgs import BackUp, DriveOnHeading, FollowPath
from hmrsim.protocol.commands import CancelGoal, SendGoal

A = "a" * 32
KINDS = {"drive_on_heading": DriveOnHeading, "back_up": BackUp}


def world(yaw=0.0, **base):
    robot = {"at": [2, 5], "yaw": yaw, "base": {"speed": 1.0, **base}}
    return {"bounds": [0, 0, 20, 10], "walls": [[[5, 0], [5, 10]]], "robots": {"wall_e": robot}}


def command(action, x, speed, **fields):
    goal = KINDS[action].Goal(target=Point(x=x, y=fields.pop("y", 0.0)), speed=speed, **fields)
    return SendGoal("wall_e", action, goal, A, A)


def end_of(log):
    return (*log.changes(A)[-1], log.result(A).error_code, log.result(A).error_msg)


@pytest.mark.parametrize(
    ("action", "x", "speed", "where"),
    [
        ("drive_on_heading", 1.0, 0.5, (2.0, 6.0)),
        ("drive_on_heading", -1.0, -0.5, (2.0, 4.0)),
        ("back_up", 1.0, 0.5, (2.0, 4.0)),
        ("back_up", -1.0, -0.5, (2.0, 4.0)),
    ],
)
def test_it_drives_the_distance_at_the_speed_and_keeps_its_yaw(make_run, action, x, speed, where):
    run = make_run(world(yaw=math.pi / 2))
    log = run((1.0, command(action, x, speed)))
    pose = run.simulator.robots["wall_e"].pose()

    assert (3.0, "SUCCEEDED", 0, "") == end_of(log)
    assert where == pytest.approx(pose.point)
    assert math.pi / 2 == pose.yaw
    assert Duration(sec=2) == log.result(A).total_elapsed_time


def test_backing_up_has_a_negative_velocity_and_a_positive_distance(make_run):
    run = make_run(world())
    run((0.0, command("back_up", 1.0, 0.5)), until=1.0)
    velocity = run.simulator.robots["wall_e"].velocity()
    distances = {round(at, 6): feedback.distance_traveled for at, feedback in run(until=5.0).feedback(A)}

    assert (-0.5, 0.0) == velocity
    assert (0.5, 1.0) == pytest.approx((distances[1.0], distances[2.0]))


@pytest.mark.parametrize(
    ("base", "x", "speed", "end"),
    [({}, 2.0, 9.0, 2.0), ({"acceleration": 1.0}, 1.0, 5.0, 2.0), ({"flies": True}, 4.0, 1.0, 4.0)],
    ids=["the robot's speed", "acceleration", "over a wall"],
)
def test_the_base_limits_the_motion(make_run, base, x, speed, end):
    log = make_run(world(**base))((0.0, command("drive_on_heading", x, speed)))

    assert (end, "SUCCEEDED", 0, "") == end_of(log)


@pytest.mark.parametrize(("action", "yaw", "code"), [("drive_on_heading", 0.0, 723), ("back_up", math.pi, 714)])
def test_it_drives_up_to_a_wall_and_no_further(make_run, action, yaw, code):
    run = make_run(world(yaw=yaw))
    log = run((0.0, command(action, 4.0, 1.0)))
    time, status, *why = end_of(log)

    assert (pytest.approx(3.0, abs=1e-5), "ABORTED") == (time, status)
    assert [code, "blocked: an obstacle at (5, 5)"] == why
    assert (5.0, 5.0) == pytest.approx(run.simulator.robots["wall_e"].pose().point, abs=1e-5)


def test_it_can_leave_a_wall(make_run):
    """A robot keeps a tiny distance from the wall at which it stops."""
    run = make_run(world())
    run((0.0, command("drive_on_heading", 4.0, 1.0)))
    log = run((10.0, command("back_up", 1.0, 1.0)._replace(goal_id="b" * 32)))

    assert (pytest.approx(11.0), "SUCCEEDED") == log.changes("b" * 32)[-1]


def test_it_drives_up_to_the_edge_of_the_map(make_run):
    run = make_run(world(yaw=math.pi / 2))
    log = run((0.0, command("drive_on_heading", 7.0, 1.0)))

    assert (5.0, "ABORTED", 723, "blocked: the edge of the map at (2, 10)") == end_of(log)


def test_a_flying_robot_follows_a_path_over_walls_but_not_off_the_map(make_run):
    path = {"path": {"poses": [{"pose": {"position": {"x": x, "y": 5.0}}} for x in (6.0, 25.0)]}}
    run = make_run(world(flies=True))
    log = run((0.0, SendGoal("wall_e", "follow_path", FollowPath.Goal.model_validate(path), A)))

    assert (4.0, "ABORTED", 106, "blocked: the edge of the map at (20, 5)") == end_of(log)


@pytest.mark.parametrize(
    ("action", "x", "speed", "y", "code", "text"),
    [
        ("drive_on_heading", 1.0, 1.0, 2.0, 724, "target (1, 2, 0) is not straight ahead; give x alone"),
        ("back_up", 1.0, 1.0, 2.0, 713, "target (1, 2, 0) is not straight ahead; give x alone"),
        ("drive_on_heading", 1.0, -1.0, 0.0, 724, "the signs of distance 1 and speed -1 differ; give both the same"),
        ("drive_on_heading", 1.0, 0.0, 0.0, 724, "at speed 0 it would take for ever; give another"),
        ("back_up", 1.0, 0.0, 0.0, 713, "at speed 0 it would take for ever; give another"),
    ],
)
def test_invalid_goals_are_aborted_at_once(make_run, action, x, speed, y, code, text):
    run = make_run(world())
    log = run((1.0, command(action, x, speed, y=y)))

    assert (1.0, "ABORTED", code, text) == end_of(log)
    assert (2.0, 5.0) == run.simulator.robots["wall_e"].pose().point


@pytest.mark.parametrize(("action", "code", "x"), [("drive_on_heading", 721, 3.0), ("back_up", 711, 1.0)])
def test_it_is_aborted_after_its_time_allowance(make_run, action, code, x):
    run = make_run(world())
    log = run((0.0, command(action, 2.0, 1.0, time_allowance=Duration(sec=1))))

    assert (1.0, "ABORTED", code, "the time allowance of 1 s is over; it takes 2 s") == end_of(log)
    assert (x, 5.0) == run.simulator.robots["wall_e"].pose().point


def test_a_canceled_robot_stops_where_it_is(make_run):
    run = make_run(world())
    log = run((0.0, command("back_up", 1.0, 1.0)), (0.5, CancelGoal("wall_e", "back_up", A)))

    assert (0.5, "CANCELED", 0, "canceled") == end_of(log)
    assert (1.5, 5.0) == run.simulator.robots["wall_e"].pose().point
    assert 0.5 == log.result(A).total_elapsed_time.to_seconds()
