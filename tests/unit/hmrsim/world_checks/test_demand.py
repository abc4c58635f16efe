"""The warnings about orders that no robot can carry out."""

from __future__ import annotations

import pytest

from hmrsim.diagnostics import dotted
from hmrsim.world import World
from hmrsim.world_checks.checks import check

WORLD = {
    "waypoints": {"a": [0, 0], "b": [10, 0]},
    "lanes": [["a", "b"]],
    "robot_types": {
        "lifter": {"components": {"claw": {"max_weight": 5}}},
        "crane": {"components": {"claw": {}}},
        "scout": {},
    },
}


def warnings(robots, weight=1, to="b", **fields):
    demand = {"name": "box", "at": "a", "to": to, "arrives": 10, "weight": weight}
    starts = {kind: {"type": kind, "at": "a"} for kind in robots}
    world = World.model_validate(WORLD | fields | {"robots": starts, "demand": [demand]})
    return [(dotted(finding.path), finding.message) for finding in check(world)]


def test_an_item_that_no_robot_lifts_is_a_warning():
    assert warnings(["lifter", "scout"], weight=9) == [("demand.0.weight", "no robot lifts 9 kg (at most 5 kg)")]


@pytest.mark.parametrize(
    ("robots", "weight"), [(["lifter"], 5), (["lifter", "crane"], 9), (["scout"], 9), ([], 9)], ids=str
)
def test_other_items_are_no_warning(robots, weight):
    """Without claws, a component of a plug-in may lift them, or a robot that a client spawns."""
    assert warnings(robots, weight=weight) == []


ROOM = [[[4, 4], [6, 4]], [[6, 4], [6, 6]], [[6, 6], [4, 6]], [[4, 6], [4, 4]]]
ATTIC = {"places": {"attic": {"at": [5, 5]}}}


def test_a_place_that_no_robot_with_the_claw_for_it_can_reach_is_a_warning():
    text = "no way leads to 'attic' at (5, 5) for lifter; join it with their lanes"

    assert warnings(["lifter", "scout"], to="attic", walls=ROOM, **ATTIC) == [("demand.0.to", text)]


def test_of_several_robots_their_number_is_named():
    ((_, text),) = warnings(["lifter", "crane"], to="attic", walls=ROOM, **ATTIC)

    assert "for any of 2 robots" in text


@pytest.mark.parametrize("walls", [[], ROOM[1:], [{"solid": [end for end, _ in ROOM]}]], ids=["none", "open", "solid"])
def test_other_places_are_no_warning(walls):
    """A claw may reach into an obstacle, such as a shelf."""
    assert warnings(["lifter"], to="attic", walls=walls, **ATTIC) == []
