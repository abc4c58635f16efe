"""Script orders for the navigation actions."""

from __future__ import annotations

import pytest

from hmrsim.goals.script_orders import read_order
from hmrsim.world.model import World
from tests.simulation import SMALL_WORLD

WORLD = World.model_validate(SMALL_WORLD)


def points(poses):
    return [(at.pose.position.x, at.pose.position.y) for at in poses]


def test_through_takes_places_or_points_between_semicolons():
    order = read_order("Through door; 3 4; shelf", WORLD)

    assert "navigate_through_poses" == order.action.name
    assert [(5.0, 2.0), (3.0, 4.0), (9.0, 2.0)] == points(order.goal.poses.goals)


def test_visit_takes_places_between_semicolons():
    order = read_order("Visit door;home", WORLD)

    assert "follow_waypoints" == order.action.name
    assert [(5.0, 2.0), (1.0, 2.0)] == points(order.goal.poses)


def test_spin_takes_radians():
    order = read_order("Spin -1.5", WORLD)

    assert ("spin", -1.5) == (order.action.name, order.goal.target_yaw)


@pytest.mark.parametrize(("word", "action"), [("Back", "back_up"), ("Drive", "drive_on_heading")])
@pytest.mark.parametrize(("rest", "distance", "speed"), [("2", 2.0, 1.0), ("2 0.5", 2.0, 0.5)])
def test_back_and_drive_take_a_distance_and_a_speed(word, action, rest, distance, speed):
    order = read_order(f"{word} {rest}", WORLD)

    assert (action, distance, speed) == (order.action.name, order.goal.target.x, order.goal.speed)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("Through door; shelv", "no waypoint, place or dock 'shelv'; did you mean 'shelf'"),
        ("Visit door;", "no waypoint, place or dock ''"),
        ("Spin", "'Spin' says too little; expected Spin RADIANS"),
        ("Spin 1 2", "expected one number of radians, got '1 2'"),
        ("Back -1", "expected a distance, and perhaps a speed, both positive, got '-1'"),
        ("Drive 1 0", "expected a distance, and perhaps a speed, both positive, got '1 0'"),
        ("Drive 1 2 3", "expected a distance, and perhaps a speed, both positive, got '1 2 3'"),
        ("Drive far", "'far' is not a number"),
    ],
)
def test_invalid_orders_are_rejected(text, message):
    with pytest.raises(ValueError, match=message):
        read_order(text, WORLD)
