"""The poses of a robot as key frames."""

from __future__ import annotations

import pytest

from hmrsim.events.robots import MotionBegan
from hmrsim.run_page.poses import KeyFrame, Poses

SECOND = 1_000_000_000


def east(duration=2.0, **further):
    return MotionBegan("eve", (0.0, 0.0, 0.0), (4.0, 0.0, 0.0), duration, None, **further)


EAST = east()


def test_a_robot_stands_until_it_moves():
    poses = Poses(0.1)
    poses.put(0, 0.0, 0.0, 0.0)
    poses.move(5 * SECOND, EAST)

    assert [
        KeyFrame(0, 0.0, 0.0, 0.0),
        KeyFrame(5 * SECOND, 0.0, 0.0, 0.0),
        KeyFrame(7 * SECOND, 4.0, 0.0, 0.0),
    ] == poses.frames


def test_a_motion_that_ends_early_ends_where_the_robot_is():
    poses = Poses(0.1)
    poses.move(0, EAST)
    poses.halt(SECOND)

    assert KeyFrame(SECOND, 2.0, 0.0, 0.0) == poses.frames[-1]


def test_a_robot_stops_at_the_given_point():
    poses = Poses(0.1)
    poses.move(0, EAST)
    poses.halt(SECOND, (2.5, 0.0))

    assert KeyFrame(SECOND, 2.5, 0.0, 0.0) == poses.frames[-1]


def test_following_motions_are_part_of_a_motion():
    north = {"from": (4.0, 0.0, 1.5), "to": (4.0, 2.0, 1.5), "duration": 1.0, "lane": None}
    turn = {"from": (4.0, 0.0, 0.0), "to": (4.0, 0.0, 1.5), "duration": 0.5, "lane": None, "turned": 1.5}
    poses = Poses(0.1)
    poses.move(0, east(then=(turn, north)))

    assert [0.0, 2.0, 2.5, 3.5] == [frame.at / SECOND for frame in poses.frames]
    assert KeyFrame(3_500_000_000, 4.0, 2.0, 1.5) == poses.frames[-1]


def test_a_turn_the_long_way_round_is_kept():
    turn = MotionBegan("eve", (0.0, 0.0, 0.0), (0.0, 0.0, -1.0), 1.0, None, turned=5.28)
    poses = Poses(0.1)
    poses.move(0, turn)

    assert pytest.approx(5.28) == poses.frames[-1].yaw


def test_a_change_of_speed_is_approximated():
    """From rest to rest over 4 m at 1 m/s²: after a quarter of the time, an eighth of the way."""
    poses = Poses(0.05)
    poses.move(0, east(4.0, profile=(4.0, 10.0, 1.0, 0.0)))

    assert KeyFrame(SECOND, pytest.approx(0.5), 0.0, 0.0) in poses.frames


def test_a_passenger_of_a_lift_stays_until_the_ride_ends():
    ride = MotionBegan("eve", (0.0, 0.0, 0.0), (9.0, 9.0, 0.0), 3.0, None, ride=True)
    poses = Poses(0.1)
    poses.move(0, ride)
    poses.halt(4 * SECOND)

    assert [KeyFrame(3 * SECOND, 0.0, 0.0, 0.0), KeyFrame(3 * SECOND, 9.0, 9.0, 0.0)] == poses.frames[-2:]


def test_frames_are_encoded_as_differences():
    poses = Poses(0.1)
    poses.move(SECOND, EAST)

    assert [1_000_000, 0, 50, 0, 2_000_000, 80, 0, 0] == poses.encoded(lambda at: (2 * at[0], 5 - at[1]), turns=-1.0)
