"""Capacities that can't have an effect."""

from __future__ import annotations

import pytest

from hmrsim.world.model import World
from hmrsim.world_checks.traffic import check_traffic

WAYPOINTS = {"a": (0.0, 0.0), "b": (1.0, 0.0)}


@pytest.mark.parametrize(
    ("fields", "path"),
    [
        ({"lanes": [{"from": "a", "to": "b"}, {"from": "b", "to": "a", "capacity": 2}]}, ("lanes", 1, "capacity")),
        ({"waypoints": {**WAYPOINTS, "c": {"at": (2.0, 0.0), "capacity": 2}}}, ("waypoints", "c", "capacity")),
    ],
)
def test_a_capacity_without_traffic(fields, path):
    """The world is warned of, once: its author thinks that robots wait for each other."""
    world = World.model_validate({"waypoints": WAYPOINTS, **fields})

    (found,) = check_traffic(world)
    assert (path, "warning") == (found.path, found.severity)
    assert found.message.startswith("has no effect without traffic")


@pytest.mark.parametrize("policy", ["free", "priority"])
def test_a_capacity_with_traffic(policy):
    """Also under a policy that has no use for it: it was chosen, perhaps for one run."""
    lanes = [{"from": "a", "to": "b", "capacity": 2}]
    world = World.model_validate({"waypoints": WAYPOINTS, "lanes": lanes, "traffic": {"policy": policy}})

    assert [] == [*check_traffic(world)]
