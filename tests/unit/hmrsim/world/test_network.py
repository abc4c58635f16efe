"""The network of a world, and its graph for networkx."""

from __future__ import annotations

import math
import subprocess
import sys

import networkx as nx
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.world import World
from hmrsim.world.network import nearest

TWO_LEVELS = World.model_validate(
    {
        "name": "two levels",
        "waypoints": {"hall": [0, 0], "foot": [10, 0], "head": [50, 0], "attic": {"at": [56, 0], "capacity": 2}},
        "lanes": [
            {"from": "hall", "to": "foot", "speed_limit": 0.5, "capacity": 1},
            {"from": "head", "to": "attic", "one_way": True},
        ],
        "lifts": {"tower": {"stops": ["foot", "head"], "travel_time": 6, "door_time": 2}},
        "doors": {"gate": {"at": [[5, -1], [5, 1]]}, "vault": {"at": [[53, -1], [53, 1]], "opens_for": []}},
        "places": {"desk": {"at": [1, 1]}, "lounge": {"at": [50.5, 3]}},
        "docks": {"plug": {"at": "hall"}},
    }
)


def test_a_lane_is_an_edge_each_way():
    expected = {
        "length": 10.0,
        "speed_limit": 0.5,
        "cost": 20.0,
        "capacity": 1,
        "one_way": False,
        "lift": None,
        "ride": 0.0,
        "doors": ("gate",),
        "closed": False,
    }
    edges = TWO_LEVELS.graph.edges

    assert [expected, expected] == [edges["hall", "foot"], edges["foot", "hall"]]
    assert {"name": "two levels", "units": "m", "speed": 1.0} == TWO_LEVELS.graph.graph


def test_a_one_way_lane_is_one_edge():
    lane = TWO_LEVELS.graph.edges["head", "attic"]

    assert (True, math.inf, 6.0, True) == (lane["one_way"], lane["speed_limit"], lane["cost"], lane["closed"])
    assert not TWO_LEVELS.graph.has_edge("attic", "head")


def test_a_ride_costs_its_duration():
    ride = TWO_LEVELS.graph.edges["foot", "head"]

    assert ("tower", 10.0, 10.0, 0.0) == (ride["lift"], ride["ride"], ride["cost"], ride["length"])


def test_a_waypoint_is_a_node():
    nodes = TWO_LEVELS.graph.nodes

    assert {"pos": (0.0, 0.0), "level": 0, "capacity": None, "places": ("desk", "plug"), "lifts": ()} == nodes["hall"]
    assert {"pos": (56.0, 0.0), "level": 1, "capacity": 2, "places": (), "lifts": ()} == nodes["attic"]
    assert (("lounge",), ("tower",)) == (nodes["head"]["places"], nodes["head"]["lifts"])


def test_levels_continue_over_several_lifts():
    world = World.model_validate(
        {
            "waypoints": {name: [x, 0] for x, name in enumerate("abcdef")},
            "lanes": [["b", "c"]],
            "lifts": {"upper": {"stops": ["c", "d"]}, "lower": {"stops": ["a", "b"]}, "other": {"stops": ["e", "f"]}},
        }
    )

    assert {"a": 0, "b": 1, "c": 1, "d": 2, "e": 0, "f": 1} == dict(world.graph.nodes(data="level"))


def test_the_graph_is_frozen_but_its_copy_is_not():
    with pytest.raises(nx.NetworkXError, match="Frozen graph"):
        TWO_LEVELS.graph.remove_node("hall")

    changed = TWO_LEVELS.graph.copy()
    changed.remove_node("hall")
    assert 4 == len(TWO_LEVELS.graph)


@pytest.mark.parametrize("world", [{}, {"waypoints": {"a": [0, 0]}, "places": {"here": {"at": [0, 0]}}}])
def test_a_world_without_lanes_has_nodes_without_places(world):
    graph = World.model_validate(world).graph

    assert (len(world.get("waypoints", {})), 0) == (len(graph), graph.number_of_edges())
    assert not any(places for _, places in graph.nodes(data="places"))


coordinates = st.tuples(st.integers(-9, 9), st.integers(-9, 9))


@given(st.lists(coordinates, min_size=1, max_size=30), coordinates)
def test_the_nearest_waypoint_is_that_of_all(points, here):
    """Ties are broken by name."""
    waypoints = {f"w{number:02}": point for number, point in enumerate(points)}

    assert {"here": min(waypoints, key=lambda name: (math.dist(waypoints[name], here), name))} == nearest(
        waypoints, {"here": here}
    )


def test_a_simulation_does_not_import_networkx():
    """Most runs have no need for it, and the import takes time."""
    program = (
        "import sys, hmrsim.cli.map, hmrsim_zenoh.hosting.host\n"
        "from hmrsim.simulation.simulator import Simulator\n"
        "from hmrsim import load_world\n"
        "Simulator(load_world('hospital').world)\n"
        "print('networkx' in sys.modules)\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)

    assert "False\n" == done.stdout
