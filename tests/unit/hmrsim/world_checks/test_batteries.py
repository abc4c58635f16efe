"""Batteries: charges that may be meant as shares, and drains of actions that do not exist."""

from __future__ import annotations

import pytest

from hmrsim.world.model import World
from hmrsim.world_checks.robots import check_batteries


def findings(battery, kind=None):
    """Return what is said of a robot with a battery, whose type may have one, too."""
    world = {
        "waypoints": {"home": [0, 0]},
        "robot_types": {"cart": {"components": {"battery": kind or {}}}},
        "robots": {"eve": {"at": "home", "type": "cart", "components": {"battery": battery}}},
    }
    return [(".".join(map(str, each.path)), each.message) for each in check_batteries(World.model_validate(world))]


@pytest.mark.parametrize(
    ("battery", "kind", "message"),
    [
        ({"capacity": 3000, "initial_charge": 0.3}, {}, "0.3 of 3000 units is next to nothing; 30% of it are 900"),
        ({"initial_charge": 1}, {"capacity": 500}, "1 of 500 units is next to nothing; 100% of it are 500"),
        ({"initial_charge": 0.5}, {}, "0.5 of 3600 units is next to nothing; 50% of it are 1800"),
    ],
)
def test_a_charge_that_may_be_a_share(battery, kind, message):
    """It is in units, as the capacity is."""
    assert [("robots.eve.components.battery.initial_charge", message)] == findings(battery, kind)


@pytest.mark.parametrize(
    "battery", [{"initial_charge": 0}, {"initial_charge": 900}, {"capacity": 1, "initial_charge": 0.3}, {}]
)
def test_other_charges(battery):
    """An empty battery is meant so, and so is a small one."""
    assert [] == findings(battery)


def test_a_drain_of_an_action_that_does_not_exist():
    """With the one that may be meant."""
    ((path, message),) = findings({"drain": {"actions": {"pick": 1}}})

    assert ("robots.eve.components.battery.drain.actions.pick", "no action 'pick'; did you mean 'pickup'?") == (
        path,
        message,
    )
