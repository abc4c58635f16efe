"""The parts of a world, and worlds with less of them."""

from __future__ import annotations

from hmrsim.fault_search.shrinking import parts_of, restricted, tidied

WORLD = {
    "waypoints": {"a": [0, 0], "b": [1, 0], "c": [2, 0]},
    "lanes": [["a", "b"], {"from": "b", "to": "c", "one_way": True}],
    "places": {"shelf": {"at": [2, 1]}},
    "robot_types": {"nurse": {}, "drone": {}},
    "robots": {"wall_e": {"at": "a", "type": "nurse"}, "eve": {"at": "b", "type": "drone"}},
}


def test_parts_are_entries_by_name_or_by_index():
    """Of mappings the names, of lists the indices."""
    parts = parts_of(WORLD, ("robots", "lanes", "doors"))

    assert parts == [("robots", "wall_e"), ("robots", "eve"), ("lanes", 0), ("lanes", 1)]


def test_a_world_keeps_what_is_kept():
    """A key without entries is left out; other keys stay as they are."""
    world = restricted(WORLD, ("robots", "places"), [("robots", "eve")])

    assert world["robots"] == {"eve": {"at": "b", "type": "drone"}}
    assert "places" not in world
    assert world["lanes"] == WORLD["lanes"]


def test_a_tidy_world_has_no_waypoint_that_nothing_leads_to():
    """One at which a robot stands stays; a robot type goes with its last robot."""
    world = tidied(restricted(WORLD, ("robots", "lanes"), [("robots", "wall_e"), ("lanes", 1)]))

    assert [*world["waypoints"]] == ["a", "b", "c"]
    assert [*world["robot_types"]] == ["nurse"]
    assert [*tidied(restricted(WORLD, ("robots", "lanes"), [("robots", "eve")]))["waypoints"]] == ["b"]
