"""Robots that stand where others have to go."""

from __future__ import annotations

import pytest

from hmrsim.world import World
from hmrsim.world.files import shipped_maps
from hmrsim.world_checks import check_world
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
    """Return the warnings for a world with these fields under a policy; nothing else is wrong with it."""
    model = World.model_validate({**world, "traffic": {"policy": policy}, **fields})
    assert [] == [problem for problem in check_world(model) if problem.severity == "error"]
    return [(finding.path, finding.message) for finding in check_obstructions(model)]


def paths(*arguments, **fields):
    """Return the fields that have a warning."""
    return [path for path, _ in warnings(*arguments, **fields)]


def demand(at, to="c"):
    """Return orders from some places to one."""
    return [{"name": "parcel", "at": at, "to": to, "arrives": 60}]


class TestDistances:
    """Places, docks and starts beside the lanes."""

    def test_a_place_too_near_to_a_waypoint(self):
        """The warning has the waypoint, the distance, and the distance that two robots need."""
        text = (
            "(4, 0.5) is 0.5 m from waypoint 'b', and two robots need 0.6 m: one that stands here keeps others out of"
            " the waypoint; move it away to 0.6 m or more"
        )
        assert [(("places", "shelf", "at"), text)] == warnings(places={"shelf": {"at": [4, 0.5]}})

    def test_a_place_too_near_to_a_lane(self):
        """The warning names the lane if no waypoint is too near."""
        text = (
            "(2, 0.4) is 0.4 m from lane 'a'-'b', and two robots need 0.6 m: one that stands here keeps others out of"
            " the lane; move it away to 0.6 m or more"
        )
        assert [(("places", "shelf", "at"), text)] == warnings(places={"shelf": {"at": [2, 0.4]}})

    def test_the_remedy_helps(self):
        """Two robots just fit beside each other at 0.6 m."""
        assert [] == warnings(places={"shelf": {"at": [4, 0.6]}})

    @pytest.mark.parametrize("at", [[4, 0], [2, 0], "b"], ids=["at a waypoint", "on a lane", "a name"])
    def test_what_is_on_the_lanes_is_not_too_near_to_them(self, at):
        """A robot on a waypoint or lane occupies it, which the policy takes into account."""
        assert [] == warnings(docks={"pad": {"at": at}})

    def test_a_dock_counts_the_robots_that_may_dock(self):
        """The wide robot does not dock there, and the two others fit."""
        robots = {**ROAD["robots"], "wide": {"type": "r", "at": "b", "base": {"radius": 0.5}}}
        docks = {"pad": {"at": [2, 0.7], "reserved_for": ["wide"]}, "own": {"at": [2, 0.9], "reserved_for": ["ann"]}}

        assert [("docks", "pad", "at")] == paths(robots=robots, docks=docks)

    def test_a_start_counts_the_radius_of_its_robot(self):
        """The robot without a radius may start nearer than the one with a radius."""
        robots = {
            **ROAD["robots"],
            "near": {"type": "r", "at": [2, 0.5]},
            "point": {"type": "r", "at": [6, 0.5], "base": {"radius": None}},
        }
        assert [("robots", "near", "at")] == paths(robots=robots)

    def test_a_start_at_a_place_has_one_warning(self):
        """It is that of the place."""
        robots = {**ROAD["robots"], "near": {"type": "r", "at": "shelf"}}

        assert [("places", "shelf", "at")] == paths(robots=robots, places={"shelf": {"at": [2, 0.5]}})

    def test_a_place_at_the_end_of_its_own_dead_end(self):
        """A robot there keeps others out of a waypoint that leads to this place only."""
        robots = {"ann": {"type": "r", "at": "d"}, "bob": {"type": "r", "at": "e"}}
        places = {"shelf": {"at": [8.5, 0]}, "bed": {"at": [0.2, 0.3]}}

        assert [] == warnings(FORK, robots=robots, places=places)

    def test_two_places_in_one_dead_end(self):
        """A robot at one of them keeps others out of the other."""
        places = {"shelf": {"at": [8.5, 0]}, "rack": {"at": [8, 0.7]}}
        robots = {**ROAD["robots"], "bob": {"type": "r", "at": "b"}}

        assert [("places", "shelf", "at")] == paths(robots=robots, places=places)

    def test_waypoints_with_room_for_any_number_are_left_out(self):
        """There is no warning for waypoints without a limit, as the policy keeps no robot out of them."""
        waypoints = {**ROAD["waypoints"], "stop": [4, 5]}
        lifts = {"lift": {"stops": ["b", "stop"]}}

        assert [] == warnings(waypoints=waypoints, lifts=lifts, places={"shelf": {"at": [4, 0.5]}})

    @pytest.mark.parametrize(("units", "at"), [("m", [4, 5.5]), ("px", [4, 401])], ids=["5 m", "400 px"])
    def test_a_place_far_from_the_lanes(self, units, at):
        """Robots drive there off the lanes, without regard to each other."""
        (warning,) = warnings(units=units, places={"shed": {"at": at}})

        limit = {"m": "5 m", "px": "400 px"}[units]
        text = (
            f"({at[0]}, {at[1]}) is more than {limit} from each lane that leads there: robots don't keep apart on that"
            " way; add a lane that ends nearer to it"
        )
        assert (("places", "shed", "at"), text) == warning

    def test_a_lane_behind_a_wall_does_not_lead_to_a_place(self):
        """The lane at 2 m is behind the wall, and the route around it is longer than 5 m."""
        wall = [[-20, 1], [20, 1]]
        far = {"waypoints": {**ROAD["waypoints"], "d": [30, 0]}, "lanes": [*ROAD["lanes"], ["c", "d"]]}

        assert [("places", "shed", "at")] == paths(**far, walls=[wall], places={"shed": {"at": [4, 2]}})

    def test_a_place_seen_past_a_wall(self):
        """A robot leaves the lane beside the wall."""
        assert [] == warnings(walls=[[[3, 1], [5, 1]]], places={"shed": {"at": [4, 2]}})


class TestStarts:
    """Robots that start where others have to go for orders."""

    def test_a_robot_at_a_place_of_orders_under_reserve(self):
        """An idle robot does not make room there, unlike under the default policy."""
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
        """The place is beside the end of the dead end, behind the robot."""
        waypoints = {**FORK["waypoints"], "f": [12, 0]}
        world = {**FORK, "waypoints": waypoints, "lanes": [*FORK["lanes"], ["c", "f"]]}

        ((path, text),) = warnings(world, "reserve", places={"shelf": {"at": [12, 1]}}, demand=demand("shelf", "d"))
        assert ("robots", "bob", "at") == path
        assert text.startswith("(8, 0) is in the way to shelf, where orders begin or end: ")

    def test_a_robot_on_a_lane_to_a_place_of_orders(self):
        """Other robots can't pass it."""
        robots = {**FORK["robots"], "bob": {"type": "r", "at": [6, 0]}}

        assert [("robots", "bob", "at")] == paths(FORK, "reserve", robots=robots, demand=demand("e"))

    def test_a_robot_at_a_place_of_orders_beside_the_lanes(self):
        """The robot occupies the spot."""
        robots = {**FORK["robots"], "bob": {"type": "r", "at": "shelf"}}
        places = {"shelf": {"at": [6, 1]}}

        assert [("robots", "bob", "at")] == paths(
            FORK, "reserve", robots=robots, places=places, demand=demand("shelf", "d")
        )

    @pytest.mark.parametrize("policy", ["priority", "planned"])
    def test_policies_that_have_idle_robots_make_room(self, policy):
        """There is no warning if the policy moves the robot aside."""
        assert [] == warnings(FORK, policy, demand=demand("e"))

    @pytest.mark.parametrize("policy", ["reserve", "priority"])
    def test_a_docked_robot_at_a_place_of_orders(self, policy):
        """A docked robot does not make room under any policy."""
        text = (
            "(8, 0) is in the way to c, where orders begin or end: a docked robot does not make room; start it"
            " elsewhere, or move the dock 'pad'"
        )
        docks = {"pad": {"at": "c"}}
        assert (("robots", "bob", "at"), text) in warnings(FORK, policy, docks=docks, demand=demand("e"))

    def test_a_place_of_orders_on_the_larger_side(self):
        """Other robots reach the place, on the larger side of the lanes, without passing the robot."""
        robots = {"ann": {"type": "r", "at": "d"}, "bob": {"type": "r", "at": "c"}}

        assert [] == warnings(FORK, "reserve", robots=robots, demand=demand("e", "a"))

    def test_a_place_with_room_for_two(self):
        """The robot that starts there is in no robot's way."""
        waypoints = {**FORK["waypoints"], "c": {"at": [8, 0], "capacity": 2}}

        assert [] == warnings(FORK, "reserve", waypoints=waypoints, demand=demand("e"))

    def test_a_robot_alone(self):
        """A single robot is in no robot's way."""
        assert [] == warnings(FORK, "reserve", robots={"bob": {"type": "r", "at": "c"}}, demand=demand("e"))


@pytest.mark.parametrize("fields", [{"robots": {}}, {"lanes": []}, {"robots": {"ann": {"type": "r", "at": "a"}}}])
def test_worlds_in_which_no_two_robots_meet_on_lanes(fields):
    """There are no warnings if no two robots can meet."""
    assert [] == warnings(places={"shelf": {"at": [4, 0.5]}}, **fields)


def test_robots_without_a_radius_are_points():
    """Robots without a radius need no distance."""
    assert [] == warnings(robot_types={"r": {}}, places={"shelf": {"at": [4, 0.5]}})


def test_under_free_no_robot_keeps_others_out():
    """There are no warnings under `free`, where robots pass through each other."""
    assert [] == warnings(policy="free", places={"shelf": {"at": [4, 0.5]}}, demand=demand("a"))


@pytest.mark.parametrize("name", shipped_maps())
def test_shipped_worlds(name):
    """The shipped worlds have no warnings."""
    assert [] == list(check_obstructions(shipped(name).world))
