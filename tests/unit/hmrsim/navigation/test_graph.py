"""Which way robots take: by time, with ties by name, and off the lanes where the line is clear."""

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
    """Return the graph of a world made of these parts."""
    return WaypointGraph(World.model_validate(world))


def points(route):
    """Return the points that a route goes through."""
    return [leg.start for leg in route.legs] + [route.legs[-1].end]


SQUARE = {
    "waypoints": {"a": [0, 0], "b": [4, 0], "c": [0, 4], "d": [4, 4]},
    "lanes": [["a", "b"], ["a", "c"], ["b", "d"], ["c", "d"]],
}


class TestWaypoints:
    """Routes between waypoints."""

    def test_equal_routes_are_ordered_by_waypoint_name(self):
        """Both ways round the square are 8 m; the one by b comes first, from either end."""
        square = graph(**SQUARE)

        assert [(0, 0), (4, 0), (4, 4)] == points(square.plan((0, 0), (4, 4), 1.0))
        assert [(4, 4), (4, 0), (0, 0)] == points(square.plan((4, 4), (0, 0), 1.0))

    def test_a_slow_lane_is_avoided_by_fast_robots_only(self):
        """A limit of 1 m/s costs a robot of 2 m/s time, and one of 1 m/s nothing."""
        world = {
            "waypoints": {"a": [0, 0], "b": [10, 0], "c": [5, 3]},
            "lanes": [{"from": "a", "to": "b", "speed_limit": 1.0}, ["a", "c"], ["c", "b"]],
        }

        assert [(0, 0), (10, 0)] == points(graph(**world).plan((0, 0), (10, 0), 1.0))
        assert [(0, 0), (5, 3), (10, 0)] == points(graph(**world).plan((0, 0), (10, 0), 2.0))

    def test_a_one_way_lane_is_not_driven_backwards(self):
        """The way back goes round."""
        world = SQUARE | {"lanes": [{"from": "a", "to": "b", "one_way": True}, ["a", "c"], ["b", "d"], ["c", "d"]]}

        assert [(0, 0), (4, 0)] == points(graph(**world).plan((0, 0), (4, 0), 1.0))
        assert [(4, 0), (4, 4), (0, 4), (0, 0)] == points(graph(**world).plan((4, 0), (0, 0), 1.0))

    def test_lanes_name_their_waypoints_in_the_direction_of_travel(self):
        """A leg says on which lane it runs."""
        route = graph(**SQUARE).plan((4, 4), (0, 0), 1.0)

        assert [("d", "b"), ("b", "a")] == [leg.lane for leg in route.legs]

    def test_there_is_no_route_to_another_component(self):
        """The code is NO_VALID_PATH and the text says from where to where."""
        world = {"waypoints": {"a": [0, 0], "b": [1, 0], "c": [5, 5], "d": [6, 5]}, "lanes": [["a", "b"], ["c", "d"]]}

        with pytest.raises(NoRoute, match=r"no route from \(0, 0\) to \(6, 5\)") as caught:
            graph(**world).plan((0, 0), (6, 5), 1.0)
        assert 208 == caught.value.code

    @given(
        st.lists(st.tuples(st.integers(0, 7), st.integers(0, 7)), min_size=1, max_size=24),
        st.lists(st.integers(0, 60), min_size=8, max_size=8, unique=True),
    )
    def test_routes_are_as_short_as_networkx_finds_them(self, pairs, places):
        """On any graph, lengths agree with Dijkstra of networkx, and legs join."""
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


class TestOffTheLanes:
    """Goals and starts that are on no waypoint."""

    def test_a_goal_on_a_lane_is_reached_along_the_lanes(self):
        """The route ends exactly there."""
        assert [(1, 2), (9, 2), (9, 5)] == points(graph(**ROOM).plan((1, 2), (9, 5), 1.0))

    def test_a_robot_on_a_lane_drives_along_it_to_a_goal_on_it(self):
        """Neither end of the lane is visited."""
        assert [(3, 2), (7, 2)] == points(graph(**ROOM).plan((3, 2), (7, 2), 1.0))

    def test_a_one_way_lane_is_left_at_its_end_even_for_a_goal_just_behind(self):
        """From 7 to 3 on a lane that leads from 1 to 9, the way is round the block."""
        world = ROOM | {"lanes": [{"from": "a", "to": "b", "one_way": True}, ["b", "c"], ["c", "d"], ["d", "a"]]}

        assert [(7, 2), (9, 2), (9, 8), (1, 8), (1, 2), (3, 2)] == points(graph(**world).plan((7, 2), (3, 2), 1.0))

    def test_start_and_goal_that_share_their_nearest_lane_go_straight(self):
        """Both are near a-b and see each other."""
        assert [(2, 3), (8, 3)] == points(graph(**ROOM).plan((2, 3), (8, 3), 1.0))

    @pytest.mark.parametrize("share", [0.001, 0.25, 0.5, 0.75])
    def test_a_robot_that_has_left_the_lanes_for_its_goal_goes_on_to_it(self, share):
        """Planned anew on the way it does not turn back to the lane, though another lane is nearer to it there."""
        world = {
            "waypoints": {"a": [0, 0], "b": [0, 5], "c": [0, 20], "d": [20, 20], "e": [30, 0]},
            "lanes": [["a", "b"], ["b", "c"], ["c", "d"], {"from": "a", "to": "e", "one_way": True}],
        }
        here = (12, 20 - 6 * share)

        assert [(0, 5), (0, 20), (12, 20), (12, 14)] == points(graph(**world).plan((0, 5), (12, 14), 1.0))
        assert [here, (12, 14)] == points(graph(**world).plan(here, (12, 14), 1.0))

    def test_a_wall_between_them_sends_them_along_the_lane(self):
        """They would go straight but for the wall, which does not reach the lane."""
        world = ROOM | {"walls": [[[5, 2.5], [5, 4]]]}

        assert [(2, 3), (2, 2), (8, 2), (8, 3)] == points(graph(**world).plan((2, 3), (8, 3), 1.0))

    def test_the_lanes_are_left_at_the_nearest_point_that_sees_the_goal(self):
        """From a, the quickest way would leave them at a; the shelf is 1 m beside b-c."""
        world = {"waypoints": {"a": [0, 0], "b": [0, 6], "c": [10, 6]}, "lanes": [["a", "b"], ["b", "c"]]}

        assert [(0, 0), (0, 6), (10, 6), (10, 5)] == points(graph(**world).plan((0, 0), (10, 5), 1.0))

    def test_a_lane_that_is_nearer_but_hidden_does_not_count(self):
        """a-b is behind a wall, c-d is not."""
        world = ROOM | {"walls": [[[0, 4], [8, 4]], [[8, 4], [8, 7]]]}

        assert [(1, 2), (9, 2), (9, 8), (3, 8), (3, 5)] == points(graph(**world).plan((1, 2), (3, 5), 1.0))

    def test_a_nearest_point_from_which_there_is_no_way_does_not_count(self):
        """The lane beside the goal leads away from it only; the next one is taken."""
        world = {
            "waypoints": {"a": [0, 0], "b": [10, 0], "c": [0, 4], "d": [10, 4]},
            "lanes": [["a", "b"], ["c", "d"]],
        }

        assert [(0, 0), (5, 0), (5, 3)] == points(graph(**world).plan((0, 0), (5, 3), 1.0))
        assert [(5, 3), (5, 0), (0, 0)] == points(graph(**world).plan((5, 3), (0, 0), 1.0))

    def test_a_lane_whose_nearest_point_is_hidden_is_left_where_the_goal_comes_into_sight(self):
        """In an alcove beside the lane: the foot is behind its wall, the mouth is further on."""
        world = ROOM | {"lanes": [["a", "b"]], "walls": [[[2, 3], [4, 3]]]}
        route = graph(**world).plan((1, 2), (3, 4), 1.0)

        # From (3, 4) past the corner (4, 3) the lane at y = 2 is seen from x = 5 on.
        assert [(1, 2), (5, 2), (3, 4)] == [pytest.approx(point, abs=1e-4) for point in points(route)]

    def test_a_start_whose_nearest_point_is_hidden_leaves_likewise(self):
        """The same way back."""
        world = ROOM | {"lanes": [["a", "b"]], "walls": [[[2, 3], [4, 3]]]}
        route = graph(**world).plan((3, 4), (1, 2), 1.0)

        assert [(3, 4), (5, 2), (1, 2)] == [pytest.approx(point, abs=1e-4) for point in points(route)]

    def test_a_goal_that_no_lane_sees_has_no_route(self):
        """A box around the goal: 208."""
        world = ROOM | {"walls": [[[4, 4], [6, 4], [6, 6], [4, 6], [4, 4]]]}

        with pytest.raises(NoRoute, match="no route") as caught:
            graph(**world).plan((1, 2), (5, 5), 1.0)
        assert 208 == caught.value.code

    def test_a_goal_outside_the_bounds_is_outside_the_map(self):
        """204, and the text names the goal and the bounds."""
        with pytest.raises(
            NoRoute, match=r"\(21, 5\) is outside the map, which spans \(0, 0\) to \(20, 10\)"
        ) as caught:
            graph(**ROOM).plan((1, 2), (21, 5), 1.0)
        assert 204 == caught.value.code

    def test_without_bounds_nothing_is_outside(self):
        """A far goal is reached straight from the nearest point of a lane."""
        world = ROOM | {"bounds": None}

        assert (90, 2) == points(graph(**world).plan((1, 2), (90, 2), 1.0))[-1]

    def test_a_goal_inside_a_solid_is_occupied(self):
        """206; so is one on a wall."""
        world = ROOM | {"walls": [{"solid": [[4, 4], [6, 4], [6, 6], [4, 6]]}, [[12, 0], [12, 10]]]}

        for goal in ((5, 5), (12, 3)):
            with pytest.raises(NoRoute, match="inside an obstacle") as caught:
                graph(**world).plan((1, 2), goal, 1.0)
            assert 206 == caught.value.code

    def test_a_drawn_lane_is_open_even_where_it_crosses_a_wall(self):
        """Walls stop only what leaves the lanes."""
        world = ROOM | {"walls": [[[5, 0], [5, 4]]]}

        assert [(1, 2), (9, 2)] == points(graph(**world).plan((1, 2), (9, 2), 1.0))

    def test_already_there_is_within_a_micrometre(self):
        """Nothing is driven."""
        assert 0.0 == graph(**ROOM).plan((1, 2), (1.0000005, 2), 1.0).length

    def test_a_waypoint_without_lanes_is_a_point_like_any_other(self):
        """It is reached from the nearest point of a lane."""
        world = ROOM | {"waypoints": ROOM["waypoints"] | {"lonely": [5, 3]}}

        assert [(1, 2), (5, 2), (5, 3)] == points(graph(**world).plan((1, 2), (5, 3), 1.0))

    def test_in_a_world_without_lanes_the_way_is_straight(self):
        """There is no lane to keep to."""
        assert [(1, 1), (4, 5)] == points(graph(bounds=[0, 0, 9, 9]).plan((1, 1), (4, 5), 1.0))

    @given(st.tuples(st.floats(0.5, 9.5), st.floats(0.5, 9.5)), st.tuples(st.floats(0.5, 9.5), st.floats(0.5, 9.5)))
    def test_routes_begin_and_end_exactly_and_join(self, start, goal):
        """From anywhere to anywhere: no gap, no length but that of the legs."""
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
def test_a_lane_is_left_where_nothing_is_in_the_way(walls, goal):
    """Among any walls: a route ends with a clear line, and there is one wherever a centimetre of the lane sees it."""
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


def test_plans_are_kept_for_each_destination(monkeypatch):
    """A second plan to a place searches nothing."""
    square = graph(**SQUARE)
    square.plan((0, 0), (4, 4), 1.0)
    searched = []
    monkeypatch.setattr(square._planner._trees, "_search", lambda *args: searched.append(args))

    square.plan((0, 4), (4, 4), 1.0)

    assert [] == searched


def test_a_route_that_is_planned_again_is_the_same():
    """Its legs are, too, so that a drive along them is not worked out again."""
    square = graph(**SQUARE)

    assert square.plan((0, 0), (4, 3), 1.0) is square.plan((0, 0), (4, 3), 1.0)
