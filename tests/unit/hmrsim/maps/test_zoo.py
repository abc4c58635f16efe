"""Small worlds with difficult traffic."""

from __future__ import annotations

from functools import cache

import pytest

from hmrsim.events.facilities import DoorOpening, LiftDeparted
from hmrsim.events.traffic import MadeRoom
from hmrsim.protocol.outputs import EventStamped
from hmrsim.protocol.topics import Topic
from hmrsim.simulation.simulator import Simulator
from hmrsim.world.files import shipped_maps
from hmrsim.world_checks import load_world
from tests.simulation import Log, simulate

pytestmark = pytest.mark.uncovered  # whole runs, of lines that other tests cover

ZOO = [name for name in shipped_maps() if name.startswith("zoo/")]


@cache
def run(name, policy):
    world = load_world(name).world
    made = simulate({**world.model_dump(mode="json", by_alias=True), "traffic": {"policy": policy}})
    made.simulator.run_scripts(3600.0)
    return made


def test_the_worlds_are_found_by_name():
    there = {"charger_queue", "corridor_swap", "crossing", "dead_end", "token_swap"}
    assert there <= {name.removeprefix("zoo/") for name in ZOO}


@pytest.mark.parametrize("policy", ["free", "reserve", "priority", "planned"])
@pytest.mark.parametrize("name", ZOO)
def test_every_goal_ends_under_every_policy(name, policy):
    made = run(name, policy)

    assert not made.simulator.scripts.running
    assert [] == list(made.simulator.dispatcher.servers.active())


@pytest.mark.parametrize("policy", ["priority", "planned"])
@pytest.mark.parametrize("name", ZOO)
def test_every_goal_succeeds_where_robots_make_room(name, policy):
    made = run(name, policy)
    scripts = made.simulator.scripts.all.values()

    assert [] == [(script.robot, script.error) for script in scripts if script.error]
    assert all(script.done == len(script.orders) for script in scripts)


@pytest.fixture
def run_scripts():
    def run_world(name):
        log = Log(frozenset({Topic.EVENTS}))
        simulator = Simulator(load_world(f"zoo/{name}").world, sinks=[log])
        simulator.run_scripts()
        ends = {script.robot: round(script.ended, 3) for script in simulator.scripts.all.values() if not script.error}
        return ends, [event.event for _, event in log.events if isinstance(event, EventStamped)]

    return run_world


def test_two_robots_swap_levels(run_scripts):
    ends, events = run_scripts("lift")

    rides = [event.robots for event in events if isinstance(event, LiftDeparted)]
    assert {"eve": 40.0, "wall_e": 50.0} == ends
    assert [(), ("eve",), ("wall_e",)] == rides


def test_a_door_opens_for_nurses_only(run_scripts):
    ends, events = run_scripts("door")

    opened_for = [event.by for event in events if isinstance(event, DoorOpening)]
    made_room = [event.robot for event in events if isinstance(event, MadeRoom)]
    assert ["burn_e", "m_o", "wall_e"] == sorted(ends)
    assert ["wall_e", "wall_e"] == opened_for
    assert {"m_o", "burn_e"} == {*made_room}
