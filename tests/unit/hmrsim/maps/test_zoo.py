"""Nasty little worlds for traffic."""

from __future__ import annotations

from functools import cache

import pytest

from hmrsim.world.files import shipped_maps
from hmrsim.world_checks import load_world
from tests.simulation import simulate

pytestmark = pytest.mark.uncovered  # whole runs, of lines that other tests cover

ZOO = [name for name in shipped_maps() if name.startswith("zoo/")]


@cache
def run(name, policy):
    """Return a simulation of one of them under a policy, after all of its scripts have ended; once for all tests."""
    world = load_world(name).world
    made = simulate({**world.model_dump(mode="json", by_alias=True), "traffic": {"policy": policy}})
    made.simulator.run_scripts(3600.0)
    return made


def test_the_zoo_is_known_by_name():
    """As all shipped worlds are."""
    there = {"charger_queue", "corridor_swap", "crossing", "dead_end", "token_swap"}
    assert there <= {name.removeprefix("zoo/") for name in ZOO}


@pytest.mark.parametrize("policy", ["free", "reserve", "priority", "planned"])
@pytest.mark.parametrize("name", ZOO)
def test_every_goal_ends(name, policy):
    """Whatever the policy."""
    made = run(name, policy)

    assert not made.simulator.scripts.running
    assert [] == list(made.simulator.dispatcher.servers.active())


@pytest.mark.parametrize("policy", ["priority", "planned"])
@pytest.mark.parametrize("name", ZOO)
def test_every_goal_succeeds_where_robots_make_room(name, policy):
    """No robot is left behind, and none gives up."""
    made = run(name, policy)
    scripts = made.simulator.scripts.all.values()

    assert [] == [(script.robot, script.error) for script in scripts if script.error]
    assert all(script.done == len(script.orders) for script in scripts)
