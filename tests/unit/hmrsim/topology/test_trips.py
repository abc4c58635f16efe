"""Trips between named places."""

from __future__ import annotations

from hmrsim.topology import seconds_at, speeds_of, trips
from hmrsim.world import World

ROOMS = {
    "waypoints": {"a": [0, 0], "b": [10, 0]},
    "lanes": [{"from": "a", "to": "b", "speed_limit": 1.0, "one_way": True}],
    "places": {"desk": {"at": [0, 0]}, "shelf": {"at": [8, 0]}, "walled in": {"at": [20, 0]}},
    "docks": {"plug": {"at": "b"}},
    "walls": [[[19, -1], [21, -1], [21, 1], [19, 1], [19, -1]]],
}


def test_trips_follow_the_routes_of_robots():
    """A place may be on a lane; one-way lanes and closed rooms are respected."""
    found = trips(World.model_validate(ROOMS), 2.0)

    assert [("desk", "plug", 10.0, 10.0), ("desk", "shelf", 8.0, 8.0)] == [
        (trip.start, trip.goal, trip.length, trip.seconds) for trip in found.found if trip.start == "desk"
    ]
    assert "no route from (10, 0) to (0, 0)" in found.failed["plug", "desk"]
    assert ("desk", "walled in") in found.failed
    assert (4, 4) == (found.places, found.of)


def test_slower_robots_take_longer():
    """The speed limit of 1 m/s does not matter to them."""
    world = World.model_validate(ROOMS)
    there = [trip for trip in trips(world, 2.0).found if trip.goal == "plug" and trip.start == "desk"]

    assert {("desk", "plug"): 20.0} == seconds_at(world, there, 0.5)


def test_many_places_are_sampled_reproducibly():
    world = World.model_validate({"places": {f"p{x:03}": {"at": [x, 0]} for x in range(150)}})
    found = trips(world, 1.0)

    assert (100, 150, 9900) == (found.places, found.of, len(found.found))
    assert found == trips(world, 1.0)


def test_the_most_common_speed_comes_first():
    """Flying robots do not count."""
    slow, fast, drone = ({"base": {"speed": speed, "flies": speed > 4}} for speed in (0.5, 2.0, 9.0))
    robots = {f"r{number}": {"type": kind, "at": [0, 0]} for number, kind in enumerate(["fast", "slow", "slow"])}
    types = {"slow": slow, "fast": fast, "drone": drone}
    world = {"robot_types": types, "robots": {**robots, "d": {"type": "drone", "at": [0, 0]}}}

    assert [(0.5, ("slow",)), (2.0, ("fast",))] == list(speeds_of(World.model_validate(world)).items())
    assert {300.0: ()} == speeds_of(World.model_validate({"units": "px", "robots": {}}))


def test_fewer_than_two_places_make_no_trip():
    assert () == trips(World.model_validate({}), 1.0).found
    assert () == trips(World.model_validate({"places": {"here": {"at": [0, 0]}}}), 1.0).found
