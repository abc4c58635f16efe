"""The checks of robots: batteries, and starts from which they get nowhere."""

from __future__ import annotations

import contextlib

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from hmrsim.errors import NoRoute
from hmrsim.geometry import Obstacles
from hmrsim.navigation.graph import WaypointGraph
from hmrsim.world.model import World
from hmrsim.world_checks import check_world
from hmrsim.world_checks.robots import check_batteries
from tests.profiles import examples


def findings(battery, kind=None):
    """Return what is said of a robot with a battery, whose type may have one, too."""
    world = {
        "waypoints": {"home": [0, 0]},
        "robot_types": {"cart": {"components": {"battery": kind or {}}}},
        "robots": {"eve": {"at": "home", "type": "cart", "components": {"battery": battery}}},
    }
    return [(".".join(map(str, each.path)), each.message) for each in check_batteries(World.model_validate(world))]


@pytest.mark.parametrize(
    ("battery", "kind", "message"),
    [
        ({"capacity": 3000, "initial_charge": 0.3}, {}, "0.3 of 3000 units is next to nothing; 30% of it are 900"),
        ({"initial_charge": 1}, {"capacity": 500}, "1 of 500 units is next to nothing; 100% of it are 500"),
        ({"initial_charge": 0.5}, {}, "0.5 of 3600 units is next to nothing; 50% of it are 1800"),
    ],
)
def test_a_charge_that_may_be_a_share(battery, kind, message):
    """There is a warning for a charge in units that looks like a share."""
    assert [("robots.eve.components.battery.initial_charge", message)] == findings(battery, kind)


@pytest.mark.parametrize(
    "battery", [{"initial_charge": 0}, {"initial_charge": 900}, {"capacity": 1, "initial_charge": 0.3}, {}]
)
def test_other_charges(battery):
    """There is no warning for empty and for small batteries."""
    assert [] == findings(battery)


def test_a_drain_of_an_action_that_does_not_exist():
    """The error suggests a similar action."""
    ((path, message),) = findings({"drain": {"actions": {"pick": 1}}})

    assert ("robots.eve.components.battery.drain.actions.pick", "no action 'pick'; did you mean 'pickup'?") == (
        path,
        message,
    )


BOX = [[4, 4], [6, 4], [6, 6], [4, 6], [4, 4]]
MAP = {
    "waypoints": {"a": [0, 0], "b": [10, 0], "end": [10, 5]},
    "lanes": [["a", "b"], {"from": "b", "to": "end", "one_way": True}],
    "walls": [BOX],
}
WALLED_IN = "(5, 5) is walled in: no straight line leads to a lane; start it where one does"


def problems(robot, **fields):
    """Return the problems of the map with a robot."""
    world = World.model_validate({**MAP, **fields, "robots": {"wall_e": robot}})
    return [(problem.severity, problem.path, problem.message) for problem in check_world(world)]


def test_inside_four_walls():
    """There is a warning for a robot inside four walls."""
    assert [("warning", "robots.wall_e.at", WALLED_IN)] == problems({"at": [5, 5]})


def test_at_a_waypoint_out_of_which_no_lane_leads():
    """There is a warning for a robot at the end of a one-way lane."""
    text = "no lane leads out of 'end'; start it elsewhere"
    assert [("warning", "robots.wall_e.at", text)] == problems({"at": "end"})


def test_behind_a_door_no_lane_leads_through():
    """A door without a lane is a wall for the planner."""
    walls = [[[6, 4], [4, 4], [4, 6], [6, 6]]]
    found = problems({"at": [5, 5]}, walls=walls, doors={"door": {"at": [[6, 4], [6, 6]]}})

    assert ("warning", "robots.wall_e.at", WALLED_IN) in found


@pytest.mark.parametrize(
    ("robot", "fields"),
    [
        ({"at": [5, 5], "base": {"flies": True}}, {}),
        ({"at": [5, 5], "planner": "external"}, {}),
        ({"at": [5, 5]}, {"lanes": [], "waypoints": {}}),
        ({"at": [5, 5]}, {"walls": [[[5.5, 4], [6, 4], [6, 6], [4, 6], [4, 4], [4.5, 4]]]}),
        ({"at": [5, 5]}, {"walls": [[[5.8, 4], [6, 4], [6, 6], [4, 6], [4, 4], [5.2, 4]]]}),
        ({"at": [5, 0]}, {"walls": [[[4, -1], [6, -1], [6, 1], [4, 1], [4, -1]]]}),
    ],
    ids=["flies", "another planner", "no lanes", "a gap before a lane", "a gap beside its foot", "on a lane"],
)
def test_what_is_not_walled_in(robot, fields):
    """There is no warning if a line or lane leads out, or if the robot needs none."""
    assert [] == [path for _, path, _ in problems(robot, **fields) if path.startswith("robots")]


POINTS = st.tuples(st.integers(-6, 6), st.integers(-6, 6))
SEGMENTS = st.lists(POINTS, min_size=2, max_size=5).filter(lambda corners: len({*corners}) > 1)


def is_planned(world, start, goals):
    """Return whether the planner knows a route from a point to any of some others."""
    graph = WaypointGraph(world)
    for goal in goals:
        with contextlib.suppress(NoRoute):
            graph.plan(start, goal, 1.0)
            return True
    return False


@examples(300)
@given(st.lists(POINTS, min_size=3, max_size=3, unique=True), st.lists(SEGMENTS, max_size=6), POINTS)
def test_the_planner_finds_no_route_from_where_a_robot_is_walled_in(waypoints, walls, start):
    """The planner finds a route exactly from the starts without a warning."""
    assume(not any(map(Obstacles(walls, ()).occupy, waypoints)))
    names = dict(zip("abc", waypoints, strict=True))
    robots = {"wall_e": {"at": start}}
    lanes = [["a", "b"], ["b", "c"]]
    world = World.model_validate({"waypoints": names, "lanes": lanes, "walls": walls, "robots": robots})
    told = [problem for problem in check_world(world) if problem.path == "robots.wall_e.at"]

    assert bool(told) != is_planned(world, world.point(world.robots["wall_e"].at), world.points.values())
