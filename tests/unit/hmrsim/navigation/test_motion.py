"""Motion: constant speed, trapezoids, turns, and poses between events."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.geometry import Pose
from hmrsim.navigation.motion import Drives, Trapezoid, drive, spin, straight
from hmrsim.navigation.route import Leg


def leg(start, end, limit=math.inf):
    return Leg(start, end, math.dist(start, end), None, limit)


def pieces(start, legs, final_yaw, **limits):
    driven = drive(start, legs, final_yaw, **limits)
    return [driven.piece(number) for number in range(len(driven.seconds))]


STRAIGHT, BEND = [leg((0, 0), (1, 0)), leg((1, 0), (4, 0))], [leg((0, 0), (1, 0)), leg((1, 0), (1, 1))]
RUN_UP = {"speed": 1.0, "acceleration": 1.0, "run_up": 0.5}


@pytest.mark.parametrize(
    ("yaw", "legs", "final_yaw", "limits", "seconds"),
    [
        (0, [leg((0, 0), (6, 0))], 0.0, {"speed": 2.0}, [3.0]),
        (0, [leg((0, 0), (2, 0)), leg((2, 0), (4, 0), 0.5)], 0.0, {"speed": 2.0}, [1.0, 4.0]),
        (3.0, BEND, 1.0, {"speed": 1.0}, [1.0, 1.0]),
        (0, [leg((0, 0), (4, 0))], 0.0, {"speed": 1.0, "acceleration": 1.0}, [5.0]),
        (0, STRAIGHT, 0.0, {"speed": 1.0, "acceleration": 1.0}, [1.5, 3.5]),
        (0, BEND, 0.0, {"speed": 9.0, "acceleration": 1.0}, [2.0, 2.0]),
        (1.0, [leg((0, 0), (4, 0))], None, RUN_UP, [5.0]),
        (0, [leg((0, 0), (4, 0), 0.5)], None, RUN_UP, [8.25]),
    ],
    ids=[
        "length divided by speed",
        "a limit of one lane",
        "instant turns",
        "a trapezoid",
        "a trapezoid over two lanes",
        "a stop at a bend",
        "a stop before a turn",
        "braking to a limit at once",
    ],
)
def test_a_motion_takes_time(yaw, legs, final_yaw, limits, seconds):
    assert seconds == pytest.approx([piece.duration for piece in pieces(Pose(0, 0, yaw), legs, final_yaw, **limits)])


def test_a_robot_turns_in_place_the_short_way():
    made = pieces(
        Pose(0, 0, math.pi / 2), [leg((0, 0), (1, 0)), leg((1, 0), (2, 0))], math.pi / 2, speed=1.0, turning_rate=0.5
    )

    assert [math.pi, 1.0, 1.0, math.pi] == [piece.duration for piece in made]
    assert Pose(0, 0, math.pi / 4) == made[0].pose(math.pi / 2)
    assert Pose(0.5, 0, 0) == made[1].pose(0.5)


def test_a_short_distance_is_a_triangle():
    assert 2.0 == Trapezoid(1.0, 5.0, 1.0).duration


@given(st.floats(0.01, 1e3), st.floats(0.01, 1e2), st.floats(0.01, 1e2), st.floats(0, 1))
def test_time_and_distance_of_a_trapezoid_are_inverse(distance, speed, acceleration, share):
    trapezoid = Trapezoid(distance, speed, acceleration)

    assert math.isclose(distance * share, trapezoid.driven(trapezoid.time(distance * share)), abs_tol=1e-6 * distance)
    assert math.isclose(trapezoid.duration, trapezoid.time(distance), rel_tol=1e-9)


@given(st.floats(0.1, 50), st.none() | st.floats(0.1, 10), st.lists(st.floats(0, 1), min_size=2, max_size=5))
def test_a_piece_only_goes_forward_up_to_its_end(length, acceleration, shares):
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
def test_a_cut_piece_keeps_its_first_seconds(piece):
    first = piece.first(0.5)

    assert (0.5, pytest.approx(piece.pose(0.5))) == (first.duration, first.end)
    assert pytest.approx(piece.pose(0.25)) == first.pose(0.25)
    assert piece.first(9.0) is piece


@pytest.mark.parametrize(("yaw", "ahead"), [(0.0, 2.0), (math.pi, -2.0)])
def test_a_straight_motion_is_ahead_or_backwards(yaw, ahead):
    piece = straight(Pose(0, 0, yaw), (4.0, 0.0), speed=2.0)

    assert (ahead, 0.0) == piece.velocity
    assert Pose(4.0, 0.0, yaw) == piece.end


def test_a_turn_may_exceed_a_full_turn():
    piece = spin(Pose(0, 0, 0.0), 3 * math.pi, 1.0)

    assert (0.0, 1.0) == piece.velocity
    assert 2.0 == piece.pose(2.0).yaw


def test_a_moving_robot_keeps_its_speed():
    (piece,) = pieces(Pose(0, 0), [leg((0, 0), (4, 0))], None, speed=1.0, acceleration=1.0, run_up=0.5)

    assert 4.5 == piece.duration
    assert (2.0, 0.0) == piece.pose(2.0).point
    assert (0.5, 0.5, 0.125) == (piece.run_up(0.0), piece.run_up(2.0), piece.run_up(4.0))


@given(st.floats(0.1, 50), st.floats(0.1, 10), st.floats(0.1, 10), st.floats(0, 1))
def test_an_instant_stop_changes_no_arrival(length, speed, acceleration, share):
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


def test_a_motion_along_the_same_legs_is_cached():
    """The poses at the start must be equal, where 0 differs from -0."""
    drives, legs, limits = Drives(8), [leg((0, 0), (6, 0))], {"speed": 2.0, "acceleration": 1.0}
    driven = drives.drive(Pose(0.0, 0.0), legs, None, **limits)

    assert driven is drives.drive(Pose(0.0, 0.0), legs, None, **limits)
    assert driven is not drives.drive(Pose(0.0, 0.0), [leg((0, 0), (6, 0))], None, **limits)
    assert driven is not drives.drive(Pose(0.0, -0.0), legs, None, **limits)
    assert driven is not drives.drive(Pose(0.0, 0.0), legs, 0.0, **limits)
    assert driven is not drives.drive(Pose(0.0, 0.0), legs, None, **limits, run_up=0.5)
