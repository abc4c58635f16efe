"""The checks of robots and docks: batteries, starts without an exit, and unreachable docks."""

from __future__ import annotations

import contextlib

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from hmrsim.diagnostics import dotted
from hmrsim.errors import NoRoute
from hmrsim.geometry import SAME_PLACE, Obstacles, distance, foot
from hmrsim.navigation.graph import WaypointGraph
from hmrsim.world.model import World
from hmrsim.world_checks.checks import check
from hmrsim.world_checks.facilities import Ways
from hmrsim.world_checks.robots import check_batteries
from tests.profiles import examples


def findings(battery, kind=None):
    """Return the findings of a robot with a battery, whose type may have one, too."""
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
def test_a_charge_that_looks_like_a_share_is_reported(battery, kind, message):
    assert [("robots.eve.components.battery.initial_charge", message)] == findings(battery, kind)


@pytest.mark.parametrize(
    "battery", [{"initial_charge": 0}, {"initial_charge": 900}, {"capacity": 1, "initial_charge": 0.3}, {}]
)
def test_other_charges_have_no_warning(battery):
    assert [] == findings(battery)


def test_a_drain_of_an_unknown_action_gets_a_suggestion():
    ((path, message),) = findings({"drain": {"actions": {"pick": 1}}})

    assert "robots.eve.components.battery.drain.actions.pick" == path
    assert "no action 'pick'; did you mean 'pickup'?" == message


BOX = [[4, 4], [6, 4], [6, 6], [4, 6], [4, 4]]
MAP = {
    "waypoints": {"a": [0, 0], "b": [10, 0], "end": [10, 5]},
    "lanes": [["a", "b"], {"from": "b", "to": "end", "one_way": True}],
    "walls": [BOX],
}
WALLED_IN = "(5, 5) is walled in: no straight line leads to a lane; start it where one does"


def problems(robot, **fields):
    world = World.model_validate({**MAP, **fields, "robots": {"wall_e": robot}})
    return [(finding.severity, dotted(finding.path), finding.message) for finding in check(world)]


def test_a_start_inside_four_walls_is_reported():
    assert [("warning", "robots.wall_e.at", WALLED_IN)] == problems({"at": [5, 5]})


def test_a_start_at_the_end_of_a_one_way_lane_is_reported():
    text = "no lane leads out of 'end'; start it elsewhere"
    assert [("warning", "robots.wall_e.at", text)] == problems({"at": "end"})


def test_a_start_behind_a_door_without_a_lane_is_reported():
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
def test_other_starts_have_no_warning(robot, fields):
    assert [] == [path for _, path, _ in problems(robot, **fields) if path.startswith("robots")]


POINTS = st.tuples(st.integers(-6, 6), st.integers(-6, 6))
SEGMENTS = st.lists(POINTS, min_size=2, max_size=5).filter(lambda corners: len({*corners}) > 1)


def is_planned(world, start, goals):
    graph = WaypointGraph(world)
    for goal in goals:
        with contextlib.suppress(NoRoute):
            graph.plan(start, goal, 1.0)
            return True
    return False


@examples(300)
@given(st.lists(POINTS, min_size=3, max_size=3, unique=True), st.lists(SEGMENTS, max_size=6), POINTS)
def test_the_planner_agrees_with_the_warnings(waypoints, walls, start):
    assume(not any(map(Obstacles(walls, ()).occupy, waypoints)))
    names = dict(zip("abc", waypoints, strict=True))
    robots = {"wall_e": {"at": start}}
    lanes = [["a", "b"], ["b", "c"]]
    world = World.model_validate({"waypoints": names, "lanes": lanes, "walls": walls, "robots": robots})
    reported = [finding for finding in check(world) if finding.path == ("robots", "wall_e", "at")]

    assert bool(reported) != is_planned(world, world.point(world.robots["wall_e"].at), world.points.values())


points = st.tuples(st.integers(0, 9), st.integers(0, 9)).map(list)
lines = st.lists(points, min_size=2, max_size=2, unique_by=tuple)
squares = st.tuples(points, st.integers(1, 4)).map(
    lambda square: {
        "solid": [[square[0][0] + dx * square[1], square[0][1] + dy * square[1]] for dx, dy in ((0, 0), (1, 0), (1, 1))]
    }
)


@st.composite
def worlds(draw):
    at = draw(st.lists(points, min_size=2, max_size=7, unique_by=tuple))
    ends = st.tuples(st.sampled_from(range(len(at))), st.sampled_from(range(len(at)))).filter(
        lambda two: two[0] < two[1]
    )
    lanes = draw(st.lists(ends, min_size=1, max_size=5, unique=True))
    return World.model_validate(
        {
            "waypoints": {f"w{i}": point for i, point in enumerate(at)},
            "lanes": [[f"w{a}", f"w{b}"] for a, b in lanes],
            "walls": [*draw(st.lists(lines, max_size=4)), *draw(st.lists(squares, max_size=2))],
        }
    )


@given(worlds(), st.tuples(st.floats(-1, 11), st.floats(-1, 11)) | points.map(lambda point: tuple(map(float, point))))
def test_parts_near_a_point_touch_it_or_see_it(world, point):
    ways = Ways(world)
    solids = [wall.solid for wall in world.walls if not isinstance(wall, tuple)]
    obstacles = Obstacles([wall for wall in world.walls if isinstance(wall, tuple)], solids)
    feet = [
        (ways._part[lane.from_], foot(point, world.points[lane.from_], world.points[lane.to])) for lane in world.lanes
    ]
    on_lane = {part for part, at in feet if distance(at, point) <= SAME_PLACE}
    seen = {part for part, at in feet if not obstacles.block(point, at)}

    assert (on_lane or seen) == ways._near(point)
