"""Values that are kept, the least recently used ones not for long."""

from __future__ import annotations

import gc
import weakref

from hmrsim.navigation.adjacency import Durations
from hmrsim.navigation.cache import LruCache
from hmrsim.navigation.graph import WaypointGraph
from hmrsim.navigation.planner import Planner
from hmrsim.world.model import World
from tests.simulation import SMALL_WORLD


def test_a_value_is_made_once():
    """As long as it is kept."""
    kept, made = LruCache[int, int](2), []

    def value(key):
        return kept.get(key, lambda: made.append(key) or -key)

    assert [value(key) for key in (1, 2, 1, 3, 1, 2)] == [-1, -2, -1, -3, -1, -2]
    assert made == [1, 2, 3, 2]


def test_a_planner_is_gone_with_its_last_use():
    """It is in no cycle, for which the garbage collector would have to come."""
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
