"""The warehouse, with its hundred busy robots."""

from __future__ import annotations

import runpy
from collections import Counter
from itertools import combinations
from math import dist

import pytest

from hmrsim.protocol.outputs import EventStamped
from hmrsim.protocol.topics import Topic
from hmrsim.simulation.scripts import ScriptState
from hmrsim.simulation.simulator import Simulator
from tests.paths import ROOT
from tests.shipped import shipped
from tests.simulation import Log

pytestmark = pytest.mark.uncovered  # whole runs, of lines that other tests cover

GENERATOR = ROOT / "tools" / "generate_warehouse.py"


@pytest.fixture(scope="module")
def world():
    return shipped("warehouse").world


def orders(robot):
    return [order.partition(" ")[::2] for order in robot.script]


def grabs(world):
    """Yield each grab as (robot, item, position of the robot)."""
    for robot in world.robots.values():
        at = world.point(robot.at)
        for word, what in orders(robot):
            if word == "Go":
                at = world.point(what)
            if word == "Grab":
                yield robot, what, at


def test_the_file_is_up_to_date_with_its_generator():
    module = runpy.run_path(str(GENERATOR))

    assert module["FILE"].read_text(encoding="utf-8") == module["generate"]()


def test_there_are_a_hundred_robots_of_seven_types(world):
    assert {
        "picker": 36,
        "shuttle": 16,
        "lifter": 14,
        "forklift": 10,
        "tug": 10,
        "parcel_cart": 8,
        "inspector": 6,
    } == Counter(robot.type for robot in world.robots.values())


def test_types_differ_in_speed_or_load(world):
    kinds = [(kind.base.speed, str(kind.components)) for kind in world.robot_types.values()]

    assert len(kinds) == len(set(kinds)) == 7


def test_parked_robots_have_room(world):
    parked = [(world.point(robot.at), world.robot_type(robot).base.radius) for robot in world.robots.values()]

    assert all(dist(a, b) > r + s for (a, r), (b, s) in combinations(parked, 2))
    assert all(dist(a, b) > r + 0.6 for a, r in parked for b in _driven_through(world))


def _driven_through(world):
    """Return the waypoints that are no end of a road."""
    degree = Counter(name for lane in world.lanes for name in (lane.from_, lane.to))
    return [point for name, point in world.points.items() if degree[name] > 1]


def test_every_script_ends_at_the_start_or_a_charger(world):
    words = {word for robot in world.robots.values() for word, _ in orders(robot)}
    docked = [name for name, robot in world.robots.items() if robot.script[-1].startswith("Dock charger_")]

    assert {"Go", "Grab", "Drop", "Wait", "Dock"} == words
    assert [f"inspector_0{i}" for i in range(1, 7)] == docked
    assert all(robot.script[-1] == f"Go {robot.at}" for name, robot in world.robots.items() if name not in docked)


def test_every_grab_can_be_done(world):
    taken = Counter()
    for robot, what, at in grabs(world):
        item, claw = world.items[what], world.robot_type(robot).components["claw"]
        taken[what] += 1
        assert dist(at, world.point(item.at)) <= claw["reach"], what
        assert item.weight <= claw["max_weight"], what
        assert ("Drop", what) in orders(robot)
    assert (76, 1) == (len(taken), max(taken.values()))


@pytest.fixture(scope="module")
def shift(world):
    log = Log(frozenset({Topic.EVENTS}))
    simulator = Simulator(world, sinks=[log])
    simulator.run_scripts()
    return simulator, [event for _, event in log.events if isinstance(event, EventStamped)]


def test_every_script_is_carried_out(world, shift):
    simulator, _ = shift

    scripts = simulator.scripts.all
    assert dict.fromkeys(world.robots, ScriptState.DONE) == {name: script.state for name, script in scripts.items()}
    assert ("reserve", 1869.9) == (world.policy, round(simulator.now, 1))


def test_robots_wait_but_never_deadlock(shift):
    kinds = Counter(event.kind for event in shift[1])

    assert (130, 0) == (kinds["went_on"], kinds["deadlock"])


def test_no_battery_runs_empty(world, shift):
    kinds = Counter(event.kind for event in shift[1])

    assert all("battery" in world.robot_type(robot).components for robot in world.robots.values())
    assert (0, 6) == (kinds["battery_empty"], kinds["charging_began"])


def test_all_but_the_bays_is_one_way(world):
    both_ways = {lane.to for lane in world.lanes if not lane.one_way}

    assert {*world.docks} | {robot.at for robot in world.robots.values()} <= both_ways
    assert all("bay" in name or name in world.docks for name in both_ways)
    assert all(lane.speed_limit for lane in world.lanes)
