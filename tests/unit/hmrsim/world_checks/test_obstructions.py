"""Robots that stand in the way of others."""

from __future__ import annotations

import pytest

from hmrsim.world import World
from hmrsim.world.files import shipped_maps
from hmrsim.world_checks.checks import check
from hmrsim.world_checks.obstructions import check_obstructions
from tests.shipped import shipped

ROAD = {
    "waypoints": {"a": [0, 0], "b": [4, 0], "c": [8, 0]},
    "lanes": [["a", "b"], ["b", "c"]],
    "robot_types": {"r": {"base": {"radius": 0.3}}},
    "robots": {"ann": {"type": "r", "at": "a"}, "bob": {"type": "r", "at": "c"}},
}
"""A road of two lanes for two robots that need 0.6 m."""

FORK = {
    **ROAD,
    "waypoints": {**ROAD["waypoints"], "d": [4, 3], "e": [4, -3]},
    "lanes": [*ROAD["lanes"], ["b", "d"], ["b", "e"]],
}
"""A crossing at b, with four dead ends."""


def warnings(world=ROAD, policy="priority", **fields):
    """Return the warnings of a world with these fields under a policy; the world must be valid otherwise."""
    model = World.model_validate({**world, "traffic": {"policy": policy}, **fields})
    assert [] == [finding for finding in check(model) if finding.severity == "error"]
    return [(finding.path, finding.message) for finding in check_obstructions(model)]


def paths(*arguments, **fields):
    return [path for path, _ in warnings(*arguments, **fields)]


def demand(at, to="c"):
    return [{"name": "parcel", "at": at, "to": to, "arrives": 60}]


class TestDistances:
    @pytest.mark.parametrize(
        ("at", "distance", "part", "name"), [([4, 0.5], "0.5", "waypoint", "'b'"), ([2, 0.4], "0.4", "lane", "'a'-'b'")]
    )
    def test_a_place_too_near_to_a_waypoint_or_lane_is_reported(self, at, distance, part, name):
        text = (
            f"({at[0]}, {at[1]}) is {distance} m from {part} {name}, and two robots need 0.6 m: one that stands here"
            f" keeps others out of the {part}; move it away to 0.6 m or more"
        )
        assert [(("places", "shelf", "at"), text)] == warnings(places={"shelf": {"at": at}})

    @pytest.mark.parametrize(("units", "at"), [("m", [4, 5.5]), ("px", [4, 401])], ids=["5 m", "400 px"])
    def test_a_place_far_from_the_lanes_is_reported(self, units, at):
        (warning,) = warnings(units=units, places={"shed": {"at": at}})

        limit = {"m": "5 m", "px": "400 px"}[units]
        text = (
            f"({at[0]}, {at[1]}) is more than {limit} from each lane that leads there: robots don't keep apart on that"
            " way; add a lane that ends nearer to it"
        )
        assert (("places", "shed", "at"), text) == warning


class TestStarts:
    def test_a_robot_at_a_place_of_orders_under_reserve(self):
        text = (
            "(8, 0) is in the way to c, where orders begin or end: under 'reserve' a robot without a goal does not make"
            " room; start it elsewhere, or use the policy 'planned'"
        )
        robots = {**FORK["robots"], "ann": {"type": "r", "at": "b"}}
        waypoints = {**FORK["waypoints"], "b": {"at": [4, 0], "capacity": 2}}
        assert [(("robots", "bob", "at"), text)] == warnings(
            FORK, "reserve", robots=robots, waypoints=waypoints, demand=demand("e")
        )

    def test_a_robot_in_a_dead_end_that_leads_to_a_place_of_orders(self):
        waypoints = {**FORK["waypoints"], "f": [12, 0]}
        world = {**FORK, "waypoints": waypoints, "lanes": [*FORK["lanes"], ["c", "f"]]}

        ((path, text),) = warnings(world, "reserve", places={"shelf": {"at": [12, 1]}}, demand=demand("shelf", "d"))
        assert ("robots", "bob", "at") == path
        assert text.startswith("(8, 0) is in the way to shelf, where orders begin or end: ")

    @pytest.mark.parametrize("policy", ["reserve", "priority"])
    def test_a_docked_robot_at_a_place_of_orders(self, policy):
        text = (
            "(8, 0) is in the way to c, where orders begin or end: a docked robot does not make room; start it"
            " elsewhere, or move the dock 'pad'"
        )
        docks = {"pad": {"at": "c"}}
        assert (("robots", "bob", "at"), text) in warnings(FORK, policy, docks=docks, demand=demand("e"))


def robot(at, **base):
    return {"type": "r", "at": at, "base": base}


SHELF = {"places": {"shelf": {"at": [4, 0.5]}}}
EAST = {**ROAD["waypoints"], "d": [30, 0]}

REPORTED = {
    "a dock for a wide robot": (
        "docks.pad",
        {
            "robots": {**ROAD["robots"], "wide": robot("b", radius=0.5)},
            "docks": {
                "pad": {"at": [2, 0.7], "reserved_for": ["wide"]},
                "own": {"at": [2, 0.9], "reserved_for": ["ann"]},
            },
        },
    ),
    "a start of a robot with a radius": (
        "robots.near",
        {"robots": {**ROAD["robots"], "near": robot([2, 0.5]), "point": robot([6, 0.5], radius=None)}},
    ),
    "a place, but not the start there": (
        "places.shelf",
        {"robots": {**ROAD["robots"], "near": robot("shelf")}, "places": {"shelf": {"at": [2, 0.5]}}},
    ),
    "two places in one dead end": (
        "places.shelf",
        {
            "robots": {**ROAD["robots"], "bob": robot("b")},
            "places": {"shelf": {"at": [8.5, 0]}, "rack": {"at": [8, 0.7]}},
        },
    ),
    "a place behind a wall, which is more than 5 m around": (
        "places.shed",
        {
            "waypoints": EAST,
            "lanes": [*ROAD["lanes"], ["c", "d"]],
            "walls": [[[-20, 1], [20, 1]]],
            "places": {"shed": {"at": [4, 2]}},
        },
    ),
    "a robot on a lane to a place of orders": (
        "robots.bob",
        {"world": FORK, "policy": "reserve", "robots": {**FORK["robots"], "bob": robot([6, 0])}, "demand": demand("e")},
    ),
    "a robot at a place of orders beside the lanes": (
        "robots.bob",
        {
            "world": FORK,
            "policy": "reserve",
            "robots": {**FORK["robots"], "bob": robot("shelf")},
            "places": {"shelf": {"at": [6, 1]}},
            "demand": demand("shelf", "d"),
        },
    ),
}

UNREPORTED = {
    "a place at the suggested distance": {"places": {"shelf": {"at": [4, 0.6]}}},
    "a dock at a waypoint": {"docks": {"pad": {"at": [4, 0]}}},
    "a dock on a lane": {"docks": {"pad": {"at": [2, 0]}}},
    "a dock at a waypoint's name": {"docks": {"pad": {"at": "b"}}},
    "a place at the end of its own dead end": {
        "world": FORK,
        "robots": {"ann": robot("d"), "bob": robot("e")},
        "places": {"shelf": {"at": [8.5, 0]}, "bed": {"at": [0.2, 0.3]}},
    },
    "a waypoint of a lift, with room for any number": {
        **SHELF,
        "waypoints": {**ROAD["waypoints"], "stop": [4, 5]},
        "lifts": {"lift": {"stops": ["b", "stop"]}},
    },
    "a place seen past a wall": {"walls": [[[3, 1], [5, 1]]], "places": {"shed": {"at": [4, 2]}}},
    "idle robots that make room under priority": {"world": FORK, "policy": "priority", "demand": demand("e")},
    "idle robots that make room under planned": {"world": FORK, "policy": "planned", "demand": demand("e")},
    "orders on the larger side": {
        "world": FORK,
        "policy": "reserve",
        "robots": {"ann": robot("d"), "bob": robot("c")},
        "demand": demand("e", "a"),
    },
    "a waypoint with room for two": {
        "world": FORK,
        "policy": "reserve",
        "waypoints": {**FORK["waypoints"], "c": {"at": [8, 0], "capacity": 2}},
        "demand": demand("e"),
    },
    "a single robot": {"world": FORK, "policy": "reserve", "robots": {"bob": robot("c")}, "demand": demand("e")},
    "no robots": {**SHELF, "robots": {}},
    "no lanes": {**SHELF, "lanes": []},
    "one robot on lanes": {**SHELF, "robots": {"ann": robot("a")}},
    "robots without a radius": {**SHELF, "robot_types": {"r": {}}},
    "robots that pass through each other": {**SHELF, "policy": "free", "demand": demand("a")},
}


@pytest.mark.parametrize(("path", "fields"), REPORTED.values(), ids=REPORTED)
def test_obstructions_are_reported(path, fields):
    assert [(*path.split("."), "at")] == paths(**fields)


@pytest.mark.parametrize("fields", UNREPORTED.values(), ids=UNREPORTED)
def test_other_worlds_have_no_warning(fields):
    assert [] == warnings(**fields)


@pytest.mark.parametrize("name", shipped_maps())
def test_shipped_worlds_have_no_warnings(name):
    assert [] == list(check_obstructions(shipped(name).world))
