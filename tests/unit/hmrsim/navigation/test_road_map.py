"""The road map that worlds with the same map share, and the caches of planners."""

from __future__ import annotations

import gc
import math
import weakref
from typing import TYPE_CHECKING, Any

import pytest

from hmrsim.caches import LruCache
from hmrsim.navigation.adjacency import Durations
from hmrsim.navigation.graph import WaypointGraph, road_map_of
from hmrsim.navigation.planner import Planner
from hmrsim.world.model import World
from tests.simulation import SMALL_WORLD

if TYPE_CHECKING:
    from collections.abc import Mapping


def world(**changes: Any) -> World:
    return World.model_validate({**SMALL_WORLD, **changes})


@pytest.mark.parametrize("changes", [{}, {"robots": {}, "remap": {}}, {"items": {}}, {"seed": 5}, {"name": "other"}])
def test_worlds_with_the_same_map_share_a_road_map(changes: Mapping[str, Any]):
    assert road_map_of(world()) is road_map_of(world(**changes))


def test_worlds_whose_doors_differ_in_time_share_a_road_map():
    door = {"at": [[3, 1], [3, 3]]}

    assert road_map_of(world(doors={"gate": door})) is road_map_of(world(doors={"gate": {**door, "opening_time": 7.0}}))


@pytest.mark.parametrize(
    "changes",
    [
        {"bounds": [0, 0, 20, 11]},
        {"waypoints": {**SMALL_WORLD["waypoints"], "home": [1, 2.5]}},
        {"lanes": SMALL_WORLD["lanes"][:2]},
        {"walls": SMALL_WORLD["walls"][:1]},
        {"doors": {"gate": {"at": [[3, 1], [3, 3]]}}},
        {"lifts": {"lift": {"stops": ["far", "shelf"]}}},
        {"waypoints": {**SMALL_WORLD["waypoints"], "zero": [0.0, 2]}},
        {"waypoints": {**SMALL_WORLD["waypoints"], "zero": [-0.0, 2]}},
    ],
)
def test_worlds_with_other_maps_share_no_road_map(changes: Mapping[str, Any]):
    """The sign of a zero makes another map, as it shows in a trace."""
    others = ({}, {"waypoints": {**SMALL_WORLD["waypoints"], "zero": [0.0, 2]}})

    road_maps = [road_map_of(world(**other)) for other in others if repr(other) != repr(changes)]

    assert all(road_map_of(world(**changes)) is not other for other in road_maps)


def test_changes_of_a_run_stay_in_its_graph():
    one, other = WaypointGraph(world()), WaypointGraph(world())
    one.closed = frozenset({("home", "door"), ("door", "home")})
    one.doors.set(((3, 1), (3, 3)), is_open=False)
    one.avoid([0], 2.0)

    assert other.closed == frozenset()
    assert (False, True) == (one.clear_now((2, 2), (4, 2)), other.clear_now((2, 2), (4, 2)))
    assert one.seconds(1.0)[0] == 2 * other.seconds(1.0)[0]
    assert other.plan((1, 2), (5, 2), 1.0).length == 4.0


def test_a_cached_plan_keeps_the_sign_of_zero():
    ends = [WaypointGraph(world()).plan((2.0, 2.0), (0.0, y), 1.0).legs[-1].end[1] for y in (0.0, -0.0, 0.0)]

    assert [1.0, -1.0, 1.0] == [math.copysign(1.0, y) for y in ends]


def test_a_value_is_computed_once():
    kept, made = LruCache[int, int](2), []

    def value(key):
        return kept.get(key, lambda: made.append(key) or -key)

    assert [value(key) for key in (1, 2, 1, 3, 1, 2)] == [-1, -2, -1, -3, -1, -2]
    assert made == [1, 2, 3, 2]


def test_a_planner_is_freed_with_its_last_reference():
    graph = WaypointGraph(World.model_validate(SMALL_WORLD))
    planner = Planner(graph.lanes, Durations(graph.lanes.ways))
    first, last, *_ = graph.waypoints.values()
    planner.plan(first, last, 1.0)
    planner.plan((first[0] + 0.1, first[1]), last, 1.0)
    seen = weakref.ref(planner)
    gc.disable()
    try:
        del planner
    finally:
        gc.enable()

    assert seen() is None
