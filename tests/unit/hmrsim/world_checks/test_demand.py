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
