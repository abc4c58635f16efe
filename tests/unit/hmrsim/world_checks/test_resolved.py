"""Resolved worlds: defaults applied, and names looked up."""

from __future__ import annotations

import json

import pytest

from hmrsim.world.model import World
from hmrsim.world_checks.resolved import resolved, shown, type_order

WORLD = {
    "name": "small",
    "waypoints": {"a": [0, 0], "b": {"at": [10, 0], "capacity": 3}, "c": [10, 10], "up": [110, 10]},
    "lanes": [["a", "b"], {"from": "b", "to": "c", "one_way": True, "speed_limit": 0.5, "capacity": 2}],
    "traffic": {"policy": "reserve", "lane_capacity": 4},
    "walls": [[[0, 5], [5, 5]], {"solid": [[20, 20], [21, 20], [21, 21]]}],
    "doors": {"gate": {"at": [[5, -1], [5, 1]], "opening_time": 1.5}},
    "lifts": {"lift": {"stops": ["c", "up"], "travel_time": 6}},
    "places": {"ward": {"at": [10, 10]}},
    "docks": {"charger": {"at": "a", "type": "charger"}},
    "items": {"medicine": {"at": "ward", "weight": 0.2}},
    "robot_types": {"spare": {}, "nurse": {"base": {"speed": 2, "radius": 0.3}}},
    "robots": {"wall_e": {"type": "nurse", "at": "charger", "yaw": 1}, "eve": {"at": "b"}},
}


@pytest.fixture
def world():
    """The small world with all defaults applied."""
    return json.loads(json.dumps(resolved(World.model_validate(WORLD))))


def test_names_are_looked_up(world):
    assert [[0, 0], [10, 10], [0, 0]] == [world[kind][0]["at"] for kind in ("docks", "items", "robots")]
    assert [[10, 10], [110, 10]] == world["lifts"][0]["points"]
    assert "c" == world["lifts"][0]["at"]


def test_capacities_default_to_those_of_the_policy(world):
    assert [4, 2] == [lane["capacity"] for lane in world["lanes"]]
    assert [1, 3, 1, 1] == [waypoint["capacity"] for waypoint in world["waypoints"]]


def test_under_free_there_are_no_capacities():
    world = resolved(World.model_validate(WORLD | {"traffic": {}}))

    assert [None, 2] == [lane["capacity"] for lane in world["lanes"]]


def test_demands_are_named():
    world = resolved(World.model_validate(WORLD | {"demand": [{"name": "food", "at": "a", "to": "b", "arrives": 9}]}))

    assert ["food"] == world["demand"]


def test_defaults_are_applied(world):
    eve = world["robots"][1]
    pixels = resolved(World.model_validate({**WORLD, "units": "px"}))

    assert ("carrier", 0, 1.0, None, False) == tuple(eve[key] for key in ("type", "yaw", "speed", "radius", "flies"))
    assert 300.0 == pixels["robots"][1]["speed"]
    assert (3.0, None) == tuple(world["doors"][0][key] for key in ("stays_open", "opens_for"))


def test_a_door_knows_the_lanes_through_it(world):
    assert [["a", "b"]] == world["doors"][0]["lanes"]


def test_used_types_come_first():
    assert ["nurse", "carrier", "spare", "fetcher"] == type_order(World.model_validate(WORLD))


def test_fields_of_forms_have_title_and_type():
    forms = shown(World.model_validate(WORLD))

    back_up, slip = forms["actions"]["back_up"], forms["faults"]["slip"]
    distance = {"title": "Distance", "type": "number", "default": 0.5, "unit": "m", "minimum": 0.0}
    assert ("Back up", distance) == (back_up["title"], back_up["properties"]["target"]["properties"]["x"])
    assert ("robot", ["factor"]) == (slip["subject"], slip["required"])
    assert {"title": "Duration", "unit": "s"}.items() <= slip["properties"]["duration"].items()
