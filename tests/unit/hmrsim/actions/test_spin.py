"""Turning on the spot."""

from __future__ import annotations

import math

import pytest

from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.nav2_msgs import Spin
from hmrsim.protocol.commands import CancelGoal, SendGoal

A = "a" * 32


@pytest.fixture
def turner(make_run):
    """A simulation of one robot that turns by half a radian a second."""
    return make_run({"robots": {"wall_e": {"at": [3, 4], "yaw": 1.0, "base": {"turning_rate": 0.5}}}})


def spin(yaw, **fields):
    """Return the command to turn."""
    return SendGoal("wall_e", "spin", Spin.Goal(target_yaw=yaw, **fields), A, A)


@pytest.mark.parametrize(("yaw", "seconds"), [(1.5, 3.0), (-1.5, 3.0), (2 * math.pi, 4 * math.pi)])
def test_it_turns_by_the_angle_at_its_rate(turner, yaw, seconds):
    """Relative to where it faces, either way, and all the way round if asked."""
    log = turner((1.0, spin(yaw)))

    assert (pytest.approx(1.0 + seconds), "SUCCEEDED") == log.changes(A)[-1]
    assert math.isclose(1.0 + yaw, turner.simulator.robots["wall_e"].pose().yaw)
    assert (3.0, 4.0) == turner.simulator.robots["wall_e"].pose().point
    assert seconds == pytest.approx(log.result(A).total_elapsed_time.to_seconds())


def test_feedback_tells_what_is_turned_with_its_sign(turner):
    """After 2 s of a turn clockwise, and at its end."""
    log = turner((0.0, spin(-4.0)))
    told = {round(at, 6): feedback.angular_distance_traveled for at, feedback in log.feedback(A)}

    assert (-1.0, -4.0) == pytest.approx((told[2.0], told[8.0]))


def test_without_a_turning_rate_it_takes_no_time(run):
    """As turning does everywhere; the feedback tells all of it."""
    log = run((0.0, spin(1.5)))

    assert (0.0, "SUCCEEDED") == log.changes(A)[-1]
    assert [1.5] == [feedback.angular_distance_traveled for _, feedback in log.feedback(A)]
    assert 1.5 == run.simulator.robots["wall_e"].pose().yaw


def test_it_ends_when_its_time_allowance_is_over(turner):
    """ABORTED with 701, where it was then."""
    log = turner((0.0, spin(3.0, time_allowance=Duration(sec=2))))

    assert (2.0, "ABORTED") == log.changes(A)[-1]
    assert (701, "the time allowance of 2 s is over; it takes 6 s") == (
        log.result(A).error_code,
        log.result(A).error_msg,
    )
    assert Duration(sec=2) == log.result(A).total_elapsed_time
    assert 2.0 == turner.simulator.robots["wall_e"].pose().yaw


def test_a_canceled_one_stops_where_it_is_and_tells_how_long_it_took(turner):
    """After 3 s of 6."""
    log = turner((0.0, spin(3.0)), (3.0, CancelGoal("wall_e", "spin", A)))

    assert (3.0, "CANCELED") == log.changes(A)[-1]
    assert Duration(sec=3) == log.result(A).total_elapsed_time
    assert 2.5 == turner.simulator.robots["wall_e"].pose().yaw


def test_odometry_tells_the_turning_rate_also_across_pi(make_run):
    """Half a radian a second, whichever way the yaw is counted."""
    turner = make_run({"robots": {"wall_e": {"at": [0, 0], "yaw": 3.0, "base": {"turning_rate": 0.5}}}})
    turner((0.0, spin(2.0)), until=1.0)

    assert (0.0, 0.5) == turner.simulator.robots["wall_e"].velocity()
