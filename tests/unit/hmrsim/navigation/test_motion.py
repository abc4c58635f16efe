"""Driving: constant speed, trapezoids, turns, and poses between events."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.geometry import Pose
from hmrsim.navigation.motion import Drives, Trapezoid, drive, spin, straight
from hmrsim.navigation.route import Leg


def leg(start, end, limit=math.inf):
    """Return a leg."""
    return Leg(start, end, math.dist(start, end), None, limit)


def pieces(start, legs, final_yaw, **limits):
    """Return the pieces of a drive."""
    driven = drive(start, legs, final_yaw, **limits)
    return [driven.piece(number) for number in range(len(driven.seconds))]


def test_a_lane_takes_length_by_speed():
    """6 m at 2 m/s take 3 s, and halfway in time is halfway."""
    (piece,) = pieces(Pose(0, 0), [leg((0, 0), (6, 0))], 0.0, speed=2.0)

    assert 3.0 == piece.duration
    assert Pose(3.0, 0.0, 0.0) == piece.pose(1.5)


def test_a_speed_limit_holds_where_it_is():
    """The second lane is driven at 0.5 m/s."""
    first, second = pieces(Pose(0, 0), [leg((0, 0), (2, 0)), leg((2, 0), (4, 0), 0.5)], 0.0, speed=2.0)

    assert (1.0, 4.0) == (first.duration, second.duration)


def test_turning_takes_no_time_without_a_turning_rate():
    """There are pieces for the lanes only."""
    made = pieces(Pose(0, 0, 3.0), [leg((0, 0), (1, 0)), leg((1, 0), (1, 1))], 1.0, speed=1.0)

    assert [1.0, 1.0] == [piece.duration for piece in made]


def test_a_turning_rate_turns_in_place_the_short_way():
    """A quarter before, none between, a quarter back after: pi/2 rad at 0.5 rad/s is pi seconds."""
    made = pieces(
        Pose(0, 0, math.pi / 2), [leg((0, 0), (1, 0)), leg((1, 0), (2, 0))], math.pi / 2, speed=1.0, turning_rate=0.5
    )

    assert [math.pi, 1.0, 1.0, math.pi] == [piece.duration for piece in made]
    assert Pose(0, 0, math.pi / 4) == made[0].pose(math.pi / 2)


def test_acceleration_makes_a_trapezoid_over_a_straight_stretch():
    """4 m at 1 m/s and 1 m/s^2 take 1 + 3 + 1 s, whether it is one lane or two."""
    one = pieces(Pose(0, 0), [leg((0, 0), (4, 0))], 0.0, speed=1.0, acceleration=1.0)
    two = pieces(Pose(0, 0), [leg((0, 0), (1, 0)), leg((1, 0), (4, 0))], 0.0, speed=1.0, acceleration=1.0)

    assert 5.0 == sum(piece.duration for piece in one)
    assert [1.5, 3.5] == pytest.approx([piece.duration for piece in two])


def test_a_robot_with_acceleration_stops_at_a_bend():
    """Each side of the corner is its own trapezoid: 2 s and 2 s for 1 m each."""
    made = pieces(Pose(0, 0), [leg((0, 0), (1, 0)), leg((1, 0), (1, 1))], 0.0, speed=9.0, acceleration=1.0)

    assert [2.0, 2.0] == pytest.approx([piece.duration for piece in made])


def test_a_short_way_is_a_triangle():
    """1 m at 1 m/s^2 never reaches 5 m/s: it takes 2 s."""
    assert 2.0 == Trapezoid(1.0, 5.0, 1.0).duration


@given(st.floats(0.01, 1e3), st.floats(0.01, 1e2), st.floats(0.01, 1e2), st.floats(0, 1))
def test_time_and_distance_of_a_trapezoid_are_inverse(distance, speed, acceleration, share):
    """Where it is after the time that it takes to get there is there."""
    trapezoid = Trapezoid(distance, speed, acceleration)

    assert math.isclose(distance * share, trapezoid.driven(trapezoid.time(distance * share)), abs_tol=1e-6 * distance)
    assert math.isclose(trapezoid.duration, trapezoid.time(distance), rel_tol=1e-9)


@given(st.floats(0.1, 50), st.none() | st.floats(0.1, 10), st.lists(st.floats(0, 1), min_size=2, max_size=5))
def test_a_piece_only_goes_forward_and_ends_at_its_end(length, acceleration, shares):
    """Driven length never falls and never passes the end."""
    (piece,) = pieces(Pose(0, 0), [leg((0, 0), (length, 0))], 0.0, speed=2.0, acceleration=acceleration)

    driven = [piece.driven(piece.duration * share) for share in sorted(shares)]
    assert sorted(driven) == driven
    assert all(0 <= d <= length for d in driven)
    assert piece.end == piece.pose(piece.duration)


@pytest.mark.parametrize(
    "piece",
    [
        straight(Pose(0, 0, 1.0), (4.0, 0.0), speed=1.0, acceleration=1.0),
        straight(Pose(0, 0, 3.0), (4.0, 0.0), speed=0.8),
        spin(Pose(2, 2, 1.0), -7.0, 1.4),
    ],
)
def test_the_first_seconds_of_a_piece_are_as_they_were(piece):
    """Half a second of 5, in the middle and at its end; beyond its end there is nothing more."""
    first = piece.first(0.5)

    assert (0.5, pytest.approx(piece.pose(0.5))) == (first.duration, first.end)
    assert pytest.approx(piece.pose(0.25)) == first.pose(0.25)
    assert piece.first(9.0) is piece


@pytest.mark.parametrize(("yaw", "ahead"), [(0.0, 2.0), (math.pi, -2.0)])
def test_a_way_is_driven_ahead_or_backwards(yaw, ahead):
    """The robot keeps facing as it does."""
    piece = straight(Pose(0, 0, yaw), (4.0, 0.0), speed=2.0)

    assert (ahead, 0.0) == piece.velocity
    assert Pose(4.0, 0.0, yaw) == piece.end


def test_a_turn_goes_the_long_way_round_if_that_is_its_angle():
    """One whole turn and a half."""
    piece = spin(Pose(0, 0, 0.0), 3 * math.pi, 1.0)

    assert (0.0, 1.0) == piece.velocity
    assert 2.0 == piece.pose(2.0).yaw


def test_a_moving_robot_keeps_its_speed():
    """At 1 m/s, for which it takes 0.5 m at 1 m/s^2: 4 m more take 3.5 + 1 s, and 1 s more from rest."""
    (piece,) = pieces(Pose(0, 0), [leg((0, 0), (4, 0))], None, speed=1.0, acceleration=1.0, run_up=0.5)

    assert 4.5 == piece.duration
    assert (2.0, 0.0) == piece.pose(2.0).point
    assert (0.5, 0.5, 0.125) == (piece.run_up(0.0), piece.run_up(2.0), piece.run_up(4.0))


def test_a_robot_that_has_to_turn_does_not_keep_its_speed():
    """It keeps its speed straight ahead only."""
    (piece,) = pieces(Pose(0, 0, 1.0), [leg((0, 0), (4, 0))], None, speed=1.0, acceleration=1.0, run_up=0.5)

    assert 5.0 == piece.duration


def test_a_robot_faster_than_its_limit_slows_down_at_once():
    """At 1 m/s where 0.5 m/s are allowed: its run-up is cut to 0.125 m."""
    slow = leg((0, 0), (4, 0), 0.5)
    (piece,) = pieces(Pose(0, 0), [slow], None, speed=1.0, acceleration=1.0, run_up=0.5)

    assert 8.25 == piece.duration


@given(st.floats(0.1, 50), st.floats(0.1, 10), st.floats(0.1, 10), st.floats(0, 1))
def test_stopped_and_sent_on_at_once_it_arrives_as_if_nothing_had_been(length, speed, acceleration, share):
    """Wherever on its way that is."""
    (whole,) = pieces(Pose(0, 0), [leg((0, 0), (length, 0))], None, speed=speed, acceleration=acceleration)
    elapsed = whole.duration * share
    at = whole.pose(elapsed)
    rest = pieces(
        at,
        [leg(at.point, (length, 0))] if length > at.x else [],
        None,
        speed=speed,
        acceleration=acceleration,
        run_up=whole.run_up(elapsed),
    )

    assert whole.duration == pytest.approx(elapsed + sum(piece.duration for piece in rest), rel=1e-4)


def test_a_drive_along_the_same_legs_is_the_same():
    """It is made once, as long as it begins in the same pose; 0 and -0 are told apart."""
    drives, legs, limits = Drives(8), [leg((0, 0), (6, 0))], {"speed": 2.0, "acceleration": 1.0}
    driven = drives.drive(Pose(0.0, 0.0), legs, None, **limits)

    assert driven is drives.drive(Pose(0.0, 0.0), legs, None, **limits)
    assert driven is not drives.drive(Pose(0.0, 0.0), [leg((0, 0), (6, 0))], None, **limits)
    assert driven is not drives.drive(Pose(0.0, -0.0), legs, None, **limits)
    assert driven is not drives.drive(Pose(0.0, 0.0), legs, 0.0, **limits)
    assert driven is not drives.drive(Pose(0.0, 0.0), legs, None, **limits, run_up=0.5)
