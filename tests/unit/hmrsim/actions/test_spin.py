"""Turning in place with the spin action."""

from __future__ import annotations

import math

import pytest

from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.protocol.commands import CancelGoal
from tests.simulation import A, send


@pytest.fixture
def turner(make_run):
    return make_run({"robots": {"wall_e": {"at": [3, 4], "yaw": 1.0, "base": {"turning_rate": 0.5}}}})


def spin(yaw, **fields):
    return send("spin", target_yaw=yaw, **fields)


@pytest.mark.parametrize(("yaw", "seconds"), [(1.5, 3.0), (-1.5, 3.0), (2 * math.pi, 4 * math.pi)])
def test_it_turns_by_the_angle_at_its_rate(turner, yaw, seconds):
    log = turner((1.0, spin(yaw)))

    assert (pytest.approx(1.0 + seconds), "SUCCEEDED") == log.changes(A)[-1]
    assert math.isclose(1.0 + yaw, turner.simulator.robots["wall_e"].pose().yaw)
    assert (3.0, 4.0) == turner.simulator.robots["wall_e"].pose().point
    assert seconds == pytest.approx(log.result(A).total_elapsed_time.to_seconds())


def test_feedback_has_the_signed_angle(turner):
    log = turner((0.0, spin(-4.0)))
    reported = {round(at, 6): feedback.angular_distance_traveled for at, feedback in log.feedback(A)}

    assert (-1.0, -4.0) == pytest.approx((reported[2.0], reported[8.0]))


def test_without_a_turning_rate_it_takes_no_time(run):
    log = run((0.0, spin(1.5)))

    assert (0.0, "SUCCEEDED") == log.changes(A)[-1]
    assert [1.5] == [feedback.angular_distance_traveled for _, feedback in log.feedback(A)]
    assert 1.5 == run.simulator.robots["wall_e"].pose().yaw


def test_it_is_aborted_after_its_time_allowance(turner):
    log = turner((0.0, spin(3.0, time_allowance=Duration(sec=2))))

    assert (2.0, "ABORTED") == log.changes(A)[-1]
    assert 701 == log.result(A).error_code
    assert "the time allowance of 2 s is over; it takes 6 s" == log.result(A).error_msg
    assert Duration(sec=2) == log.result(A).total_elapsed_time
    assert 2.0 == turner.simulator.robots["wall_e"].pose().yaw


def test_a_canceled_robot_stops_and_reports_the_duration(turner):
    log = turner((0.0, spin(3.0)), (3.0, CancelGoal("wall_e", "spin", A)))

    assert (3.0, "CANCELED") == log.changes(A)[-1]
    assert Duration(sec=3) == log.result(A).total_elapsed_time
    assert 2.5 == turner.simulator.robots["wall_e"].pose().yaw


def test_odometry_has_the_turning_rate_across_pi(make_run):
    turner = make_run({"robots": {"wall_e": {"at": [0, 0], "yaw": 3.0, "base": {"turning_rate": 0.5}}}})
    turner((0.0, spin(2.0)), until=1.0)

    assert (0.0, 0.5) == turner.simulator.robots["wall_e"].velocity()
