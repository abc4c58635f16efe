"""Places without a route between them."""

from __future__ import annotations

from hmrsim.topology import parts, reach
from hmrsim.world import World

ONE_WAY = World.model_validate(
    {
        "waypoints": {"gate": [0, 0], "yard": [5, 0], "shed": [9, 0], "alone": [20, 0], "aside": [21, 0]},
        "lanes": [{"from": "gate", "to": "yard", "one_way": True}, ["yard", "shed"], ["alone", "aside"]],
        "places": {"entrance": {"at": [0, 1]}, "workbench": {"at": [9, 1]}, "island": {"at": [20, 1]}},
        "docks": {"plug": {"at": "yard"}},
    }
)


def test_parts_ignore_directions_and_are_ordered_by_size():
    assert [3, 2] == parts(ONE_WAY.graph)


def test_unreachable_waypoints_are_named():
    """A one-way lane leads in and not out."""
    found = reach(ONE_WAY.graph)

    assert (2, 2, 1) == found.strong
    assert {
        "entrance": ("island",),
        "island": ("entrance", "plug", "workbench"),
        "plug": ("entrance", "island"),
        "workbench": ("entrance", "island"),
    } == found.gaps
    assert 8 == found.pairs


def test_a_locked_door_closes_its_lane():
    door = {"at": [[5, -1], [5, 1]], "opens_for": []}
    world = {"waypoints": {"a": [0, 0], "b": [9, 0]}, "lanes": [["a", "b"]], "doors": {"vault": door}}
    graph = World.model_validate({**world, "places": {"in": {"at": [0, 0]}, "out": {"at": [9, 0]}}}).graph

    assert {"in": ("out",), "out": ("in",)} == reach(graph).gaps
    assert [2] == parts(graph)


def test_no_or_one_waypoint_is_no_gap():
    for waypoints in ({}, {"a": [0, 0]}):
        graph = World.model_validate({"waypoints": waypoints, "places": {"here": {"at": [1, 1]}}}).graph

        assert ((1,) * len(waypoints), {}, 0) == tuple(vars(reach(graph)).values())
