"""Routes: the quickest on lanes, with ties by name, and straight lines off the lanes."""

from __future__ import annotations

import math

import networkx as nx
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.errors import NoRoute
from hmrsim.navigation.graph import WaypointGraph
from hmrsim.world.model import World


def graph(**world):
    return WaypointGraph(World.model_validate(world))


def points(route):
    return [leg.start for leg in route.legs] + [route.legs[-1].end]


SQUARE = {
    "waypoints": {"a": [0, 0], "b": [4, 0], "c": [0, 4], "d": [4, 4]},
    "lanes": [["a", "b"], ["a", "c"], ["b", "d"], ["c", "d"]],
}


class TestWaypoints:
    def test_equal_routes_are_ordered_by_waypoint_name(self):
        square = graph(**SQUARE)

        assert [(0, 0), (4, 0), (4, 4)] == points(square.plan((0, 0), (4, 4), 1.0))
        assert [(4, 4), (4, 0), (0, 0)] == points(square.plan((4, 4), (0, 0), 1.0))

    def test_a_slow_lane_is_avoided_by_fast_robots_only(self):
        world = {
            "waypoints": {"a": [0, 0], "b": [10, 0], "c": [5, 3]},
            "lanes": [{"from": "a", "to": "b", "speed_limit": 1.0}, ["a", "c"], ["c", "b"]],
        }

        assert [(0, 0), (10, 0)] == points(graph(**world).plan((0, 0), (10, 0), 1.0))
        assert [(0, 0), (5, 3), (10, 0)] == points(graph(**world).plan((0, 0), (10, 0), 2.0))

    def test_a_one_way_lane_is_not_driven_in_reverse(self):
        world = SQUARE | {"lanes": [{"from": "a", "to": "b", "one_way": True}, ["a", "c"], ["b", "d"], ["c", "d"]]}

        assert [(0, 0), (4, 0)] == points(graph(**world).plan((0, 0), (4, 0), 1.0))
        assert [(4, 0), (4, 4), (0, 4), (0, 0)] == points(graph(**world).plan((4, 0), (0, 0), 1.0))

    def test_lanes_name_their_waypoints_in_the_direction_of_travel(self):
        route = graph(**SQUARE).plan((4, 4), (0, 0), 1.0)

        assert [("d", "b"), ("b", "a")] == [leg.lane for leg in route.legs]

    @given(
        st.lists(st.tuples(st.integers(0, 7), st.integers(0, 7)), min_size=1, max_size=24),
        st.lists(st.integers(0, 60), min_size=8, max_size=8, unique=True),
    )
    def test_routes_are_as_short_as_networkx_s(self, pairs, places):
        waypoints = {f"w{i}": [place % 8, place // 8] for i, place in enumerate(places)}
        lanes = [[f"w{a}", f"w{b}"] for a, b in dict.fromkeys(pairs) if a != b]
        world = World.model_validate({"waypoints": waypoints, "lanes": lanes})
        ways, reference = WaypointGraph(world), world.graph

        for target in [name for name in waypoints if reference.degree(name)]:
            lengths = nx.single_source_dijkstra_path_length(reference, "w0", weight="length")
            if not reference.degree("w0") or target == "w0":
                continue
            start, goal = tuple(map(float, waypoints["w0"])), tuple(map(float, waypoints[target]))
            if target not in lengths:
                with pytest.raises(NoRoute):
                    ways.plan(start, goal, 1.0)
                continue
            route = ways.plan(start, goal, 1.0)
            assert math.isclose(lengths[target], route.length, abs_tol=1e-9)
            assert all(before.end == after.start for before, after in zip(route.legs, route.legs[1:], strict=False))


ROOM = {
    "bounds": [0, 0, 20, 10],
    "waypoints": {"a": [1, 2], "b": [9, 2], "c": [9, 8], "d": [1, 8]},
    "lanes": [["a", "b"], ["b", "c"], ["c", "d"]],
}


LOOP = {"lanes": [{"from": "a", "to": "b", "one_way": True}, ["b", "c"], ["c", "d"], ["d", "a"]]}
CORNER = {"waypoints": {"a": [0, 0], "b": [0, 6], "c": [10, 6]}, "lanes": [["a", "b"], ["b", "c"]]}
PARTS = {"waypoints": {"a": [0, 0], "b": [10, 0], "c": [0, 4], "d": [10, 4]}, "lanes": [["a", "b"], ["c", "d"]]}
SCREEN = {"lanes": [["a", "b"]], "walls": [[[2, 3], [4, 3]]]}  # past its corner (4, 3), (3, 4) sees the lane from x = 5

ROUTES = {
    "to a goal on a lane": ({}, (1, 2), (9, 5), [(1, 2), (9, 2), (9, 5)]),
    "along one lane": ({}, (3, 2), (7, 2), [(3, 2), (7, 2)]),
    "back on a one-way lane": (LOOP, (7, 2), (3, 2), [(7, 2), (9, 2), (9, 8), (1, 8), (1, 2), (3, 2)]),
    "straight beside one lane": ({}, (2, 3), (8, 3), [(2, 3), (8, 3)]),
    "around a wall": ({"walls": [[[5, 2.5], [5, 4]]]}, (2, 3), (8, 3), [(2, 3), (2, 2), (8, 2), (8, 3)]),
    "from the nearest point that sees the goal": (CORNER, (0, 0), (10, 5), [(0, 0), (0, 6), (10, 6), (10, 5)]),
    "not from a nearer lane that is hidden": (
        {"walls": [[[0, 4], [8, 4]], [[8, 4], [8, 7]]]},
        (1, 2),
        (3, 5),
        [(1, 2), (9, 2), (9, 8), (3, 8), (3, 5)],
    ),
    "not from a nearer lane without a route": (PARTS, (0, 0), (5, 3), [(0, 0), (5, 0), (5, 3)]),
    "not to a nearer lane without a route": (PARTS, (5, 3), (0, 0), [(5, 3), (5, 0), (0, 0)]),
    "from where the goal comes into sight": (SCREEN, (1, 2), (3, 4), [(1, 2), (5, 2), (3, 4)]),
    "to where the start comes into sight": (SCREEN, (3, 4), (1, 2), [(3, 4), (5, 2), (1, 2)]),
    "through a wall on a lane": ({"walls": [[[5, 0], [5, 4]]]}, (1, 2), (9, 2), [(1, 2), (9, 2)]),
    "to a waypoint without lanes": (
        {"waypoints": ROOM["waypoints"] | {"lonely": [5, 3]}},
        (1, 2),
        (5, 3),
        [(1, 2), (5, 2), (5, 3)],
    ),
    "straight without lanes": ({"waypoints": {}, "lanes": []}, (1, 1), (4, 5), [(1, 1), (4, 5)]),
    "far away without bounds": ({"bounds": None}, (1, 2), (90, 2), [(1, 2), (9, 2), (90, 2)]),
}


class TestOffTheLanes:
    @pytest.mark.parametrize(("changes", "start", "goal", "expected"), ROUTES.values(), ids=ROUTES)
    def test_routes_lead(self, changes, start, goal, expected):
        route = graph(**ROOM | changes).plan(start, goal, 1.0)

        assert expected == [pytest.approx(point, abs=1e-4) for point in points(route)]

    @pytest.mark.parametrize(
        ("changes", "goal", "code", "message"),
        [
            ({"lanes": [["a", "b"], ["c", "d"]]}, (1, 8), 208, "no route from a to d"),
            ({"walls": [[[4, 4], [6, 4], [6, 6], [4, 6], [4, 4]]]}, (5, 5), 208, "no route"),
            ({}, (21, 5), 204, r"\(21, 5\) is outside the map, which spans \(0, 0\) to \(20, 10\)"),
            ({"walls": [{"solid": [[4, 4], [6, 4], [6, 6], [4, 6]]}]}, (5, 5), 206, "inside an obstacle"),
            ({"walls": [[[12, 0], [12, 10]]]}, (12, 3), 206, "inside an obstacle"),
        ],
        ids=["another component", "a closed box", "outside the bounds", "in a solid", "on a wall"],
    )
    def test_an_unreachable_goal_is_an_error(self, changes, goal, code, message):
        with pytest.raises(NoRoute, match=message) as caught:
            graph(**ROOM | changes).plan((1, 2), goal, 1.0)
        assert code == caught.value.code

    @pytest.mark.parametrize("share", [0.001, 0.25, 0.5, 0.75])
    def test_a_robot_that_has_left_the_lanes_continues_to_its_goal(self, share):
        world = {
            "waypoints": {"a": [0, 0], "b": [0, 5], "c": [0, 20], "d": [20, 20], "e": [30, 0]},
            "lanes": [["a", "b"], ["b", "c"], ["c", "d"], {"from": "a", "to": "e", "one_way": True}],
        }
        here = (12, 20 - 6 * share)

        assert [(0, 5), (0, 20), (12, 20), (12, 14)] == points(graph(**world).plan((0, 5), (12, 14), 1.0))
        assert [here, (12, 14)] == points(graph(**world).plan(here, (12, 14), 1.0))

    def test_a_goal_within_a_micrometer_is_reached(self):
        assert 0.0 == graph(**ROOM).plan((1, 2), (1.0000005, 2), 1.0).length

    @given(st.tuples(st.floats(0.5, 9.5), st.floats(0.5, 9.5)), st.tuples(st.floats(0.5, 9.5), st.floats(0.5, 9.5)))
    def test_routes_begin_and_end_exactly_and_their_legs_join(self, start, goal):
        route = graph(**ROOM).plan(start, goal, 1.0)

        assert math.isclose(route.length, math.fsum(leg.length for leg in route.legs))
        if route.legs:
            assert math.dist(start, route.legs[0].start) <= 1e-6
            assert math.dist(goal, route.legs[-1].end) <= 1e-6
        for before, after in zip(route.legs, route.legs[1:], strict=False):
            assert math.dist(before.end, after.start) <= 1e-6


@given(
    st.lists(st.tuples(*[st.tuples(st.floats(0, 10), st.floats(3, 7))] * 2), max_size=6),
    st.tuples(st.floats(0, 10), st.floats(7.5, 10)),
)
def test_a_lane_is_left_where_the_line_is_clear(walls, goal):
    """There is a route wherever a centimeter of the lane sees the goal."""
    world = {
        "waypoints": {"a": [0, 1], "b": [10, 1]},
        "lanes": [["a", "b"]],
        "walls": [list(w) for w in walls if w[0] != w[1]],
    }
    ways = graph(**world)
    seen = any(all(ways.clear_now((x / 10 + near, 1.0), goal) for near in (-0.005, 0.0, 0.005)) for x in range(1, 100))
    try:
        last = ways.plan((0, 1), goal, 1.0).legs[-1]
    except NoRoute:
        last = None

    assert (not seen) if last is None else ways.clear_now(last.start, goal)


def test_plans_are_cached_by_destination(monkeypatch):
    square = graph(**SQUARE)
    square.plan((0, 0), (4, 4), 1.0)
    searched = []
    monkeypatch.setattr(square._planner._trees, "_search", lambda *args: searched.append(args))

    square.plan((0, 4), (4, 4), 1.0)

    assert [] == searched


def test_a_cached_route_is_the_same_object():
    """The motion along its legs is then cached as well."""
    square = graph(**SQUARE)

    assert square.plan((0, 0), (4, 3), 1.0) is square.plan((0, 0), (4, 3), 1.0)
