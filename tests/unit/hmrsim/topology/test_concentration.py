"""The concentration of traffic on lanes."""

from __future__ import annotations

from importlib import import_module

import networkx as nx
import pytest

from hmrsim.topology import concentration
from hmrsim.world import World

CROSS = {
    "waypoints": {"mid": [0, 0], "north": [0, 9], "east": [9, 0], "south": [0, -9], "west": [-9, 0]},
    "lanes": [["mid", end] for end in ("north", "east", "south", "west")],
}


def shares(world, speed=1.0):
    """Return the share of trips by lane."""
    return concentration(World.model_validate(world).graph, speed).shares


def test_trips_between_all_waypoints_where_few_have_names():
    """Eight of twenty trips start or end at the end of an arm."""
    assert {("east", "mid"): 0.4, ("mid", "north"): 0.4, ("mid", "south"): 0.4, ("mid", "west"): 0.4} == shares(CROSS)


def test_trips_are_between_named_places_if_there_are_some():
    docks = {f"dock_{name}": {"at": name} for name in ("north", "east", "south")}
    found = concentration(World.model_validate({**CROSS, "docks": docks}).graph, 1.0)

    third = pytest.approx(2 / 3)
    assert {("east", "mid"): third, ("mid", "north"): third, ("mid", "south"): third} == found.shares
    assert ("places", 3, 3) == (found.between, found.starts, found.of)


def test_equally_quick_routes_share_a_trip():
    """On a square, each lane has a quarter of twelve trips, and an eighth in halves."""
    square = {
        "waypoints": {"a": [0, 0], "b": [1, 0], "c": [1, 1], "d": [0, 1]},
        "lanes": [["a", "b"], ["b", "c"], ["c", "d"], ["d", "a"]],
    }

    assert [pytest.approx(1 / 3)] * 4 == list(shares(square).values())


def test_the_quickest_route_depends_on_the_speed():
    """A limit matters only to faster robots."""
    world = {
        "waypoints": {"a": [0, 0], "b": [10, 0], "c": [5, 3]},
        "lanes": [{"from": "a", "to": "b", "speed_limit": 1.0}, ["a", "c"], ["c", "b"]],
    }

    assert ("a", "b") in shares(world, 1.0)
    assert ("a", "b") not in shares(world, 2.0)


@pytest.mark.uncovered
def test_large_graphs_are_sampled_reproducibly(monkeypatch):
    cells = nx.grid_2d_graph(20, 20)
    world = World.model_validate(
        {
            "waypoints": {f"{x:02}_{y:02}": [x, y] for x, y in cells},
            "lanes": [[f"{a:02}_{b:02}", f"{c:02}_{d:02}"] for (a, b), (c, d) in cells.edges],
        }
    )
    whole = concentration(world.graph, 1.0)
    monkeypatch.setattr(import_module("hmrsim.topology.concentration"), "MAX_STEPS", 200_000)
    found = concentration(world.graph, 1.0)

    assert (400, 131, 400) == (whole.starts, found.starts, found.of)
    assert found == concentration(world.graph, 1.0)
    assert max(abs(share - whole.shares[lane]) for lane, share in found.shares.items()) < 0.02


def test_without_lanes_there_is_no_traffic():
    assert {} == shares({}) == shares({"waypoints": {"a": [0, 0]}})
