"""A world as programs that show it get it: defaults applied, names looked up."""

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
    """The small world, resolved."""
    return json.loads(json.dumps(resolved(World.model_validate(WORLD))))


def test_names_are_looked_up(world):
    """Docks, items, lifts and robots have the coordinates of their waypoints."""
    assert [[0, 0], [10, 10], [0, 0]] == [world[kind][0]["at"] for kind in ("docks", "items", "robots")]
    assert [[10, 10], [110, 10]] == world["lifts"][0]["points"]
    assert "c" == world["lifts"][0]["at"]


def test_capacities_are_those_of_the_traffic_unless_there_are_others(world):
    """Capacities come from the policy's settings or its defaults, unless the world has others."""
    assert [4, 2] == [lane["capacity"] for lane in world["lanes"]]
    assert [1, 3, 1, 1] == [waypoint["capacity"] for waypoint in world["waypoints"]]


def test_nothing_counts_where_traffic_is_free():
    """Under `free` there are no capacities."""
    world = resolved(World.model_validate(WORLD | {"traffic": {}}))

    assert [None, 2] == [lane["capacity"] for lane in world["lanes"]]


def test_demands_are_named():
    """The names of demands are listed."""
    world = resolved(World.model_validate(WORLD | {"demand": [{"name": "food", "at": "a", "to": "b", "arrives": 9}]}))

    assert ["food"] == world["demand"]


def test_defaults_are_applied(world):
    """Robots have default settings, with another speed in pixels."""
    eve = world["robots"][1]
    pixels = resolved(World.model_validate({**WORLD, "units": "px"}))

    assert ("carrier", 0, 1.0, None, False) == tuple(eve[key] for key in ("type", "yaw", "speed", "radius", "flies"))
    assert 300.0 == pixels["robots"][1]["speed"]
    assert (3.0, None) == tuple(world["doors"][0][key] for key in ("stays_open", "opens_for"))


def test_a_door_knows_the_lanes_through_it(world):
    """A door lists the lanes through it in their directions."""
    assert [["a", "b"]] == world["doors"][0]["lanes"]


def test_types_of_robots_that_there_are_come_first():
    """Types of the world's robots come first, then the others of the file, then built-in types."""
    assert ["nurse", "carrier", "spare", "fetcher"] == type_order(World.model_validate(WORLD))


def test_forms_come_with_the_world():
    """Each field of a form has a title and a type, nested like the message."""
    forms = shown(World.model_validate(WORLD))

    back_up, slip = forms["actions"]["back_up"], forms["faults"]["slip"]
    distance = {"title": "Distance", "type": "number", "default": 0.5, "unit": "m", "minimum": 0.0}
    assert ("Back up", distance) == (back_up["title"], back_up["properties"]["target"]["properties"]["x"])
    assert ("robot", ["factor"]) == (slip["subject"], slip["required"])
    assert {"title": "Duration", "unit": "s"}.items() <= slip["properties"]["duration"].items()
