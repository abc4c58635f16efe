"""The worlds of the zoo in which robots need a lift or a door."""

from __future__ import annotations

import pytest

from hmrsim.events.facilities import DoorOpening, LiftDeparted
from hmrsim.events.traffic import MadeRoom
from hmrsim.protocol.outputs import EventStamped
from hmrsim.protocol.topics import Topic
from hmrsim.simulation.simulator import Simulator
from hmrsim.world_checks import load_world
from tests.simulation import Log

pytestmark = pytest.mark.uncovered  # whole runs, of lines that other tests cover


@pytest.fixture
def run():
    """Return the function that runs the scripts of a world, and returns their ends and the events."""

    def simulate(name):
        log = Log(frozenset({Topic.EVENTS}))
        simulator = Simulator(load_world(f"zoo/{name}").world, sinks=[log])
        simulator.run_scripts()
        ends = {script.robot: round(script.ended, 3) for script in simulator.scripts.all.values() if not script.error}
        return ends, [event.event for _, event in log.events if isinstance(event, EventStamped)]

    return simulate


def test_two_robots_swap_levels(run):
    """The one that the lift was called for first comes down, and the other goes up with the cabin that it leaves."""
    ends, events = run("lift")

    rides = [event.robots for event in events if isinstance(event, LiftDeparted)]
    assert {"eve": 40.0, "wall_e": 50.0} == ends
    assert [(), ("eve",), ("wall_e",)] == rides


def test_a_door_opens_for_nurses_only(run):
    """The nurse drives through twice; the porters swap rooms on the way around, and give way to each other there."""
    ends, events = run("door")

    opened_for = [event.by for event in events if isinstance(event, DoorOpening)]
    made_room = [event.robot for event in events if isinstance(event, MadeRoom)]
    assert ["burn_e", "m_o", "wall_e"] == sorted(ends)
    assert ["wall_e", "wall_e"] == opened_for
    assert {"m_o", "burn_e"} == {*made_room}
