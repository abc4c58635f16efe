"""The warehouse: a hundred robots that have something to do."""

from __future__ import annotations

import runpy
from collections import Counter
from itertools import combinations
from math import dist
from pathlib import Path

import pytest

from hmrsim.scripts import ScriptState
from hmrsim.simulator import Simulator
from hmrsim.world import load_world

GENERATOR = Path(__file__).parents[2] / "tools" / "generate_warehouse.py"


@pytest.fixture(scope="module")
def world():
    """Return the warehouse."""
    return load_world("warehouse").world


def orders(robot):
    """Return the script of a robot as words and what they are about."""
    return [order.partition(" ")[::2] for order in robot.script]


def grabs(world):
    """Yield who grabs what, and where it stands then."""
    for robot in world.robots.values():
        at = world.point(robot.at)
        for word, what in orders(robot):
            if word == "Go":
                at = world.point(what)
            if word == "Grab":
                yield robot, what, at


def test_file_is_what_the_generator_writes():
    """Whoever changes one of the two changes both."""
    module = runpy.run_path(str(GENERATOR))

    assert module["FILE"].read_text(encoding="utf-8") == module["generate"]()


def test_fleet(world):
    """There are a hundred robots of seven types."""
    assert {
        "picker": 36,
        "shuttle": 16,
        "lifter": 14,
        "forklift": 10,
        "tug": 10,
        "parcel_cart": 8,
        "inspector": 6,
    } == Counter(robot.type for robot in world.robots.values())


def test_types_differ(world):
    """No two types are as fast and carry the same."""
    kinds = [(kind.base.speed, str(kind.components)) for kind in world.robot_types.values()]

    assert len(kinds) == len(set(kinds)) == 7


def test_parked_robots_have_room(world):
    """At the start no robot touches another, nor the way of one that passes by."""
    parked = [(world.point(robot.at), world.robot_type(robot).base.radius) for robot in world.robots.values()]

    assert all(dist(a, b) > r + s for (a, r), (b, s) in combinations(parked, 2))
    assert all(dist(a, b) > r + 0.6 for a, r in parked for b in _driven_through(world))


def _driven_through(world):
    """Return the waypoints that are no end of the road."""
    degree = Counter(name for lane in world.lanes for name in (lane.from_, lane.to))
    return [point for name, point in world.waypoints.items() if degree[name] > 1]


def test_everybody_has_something_to_do(world):
    """Every script is of words that robots know, and ends where the robot was parked."""
    words = {word for robot in world.robots.values() for word, _ in orders(robot)}

    assert {"Go", "Grab", "Drop", "Wait"} == words
    assert all(robot.script[-1] == f"Go {robot.at}" for robot in world.robots.values())


def test_every_grab_can_be_done(world):
    """What a script grabs is in reach, not too heavy, nobody else's, and put down again."""
    taken = Counter()
    for robot, what, at in grabs(world):
        item, claw = world.items[what], world.robot_type(robot).components["claw"]
        taken[what] += 1
        assert dist(at, world.point(item.at)) <= claw["reach"], what
        assert item.weight <= claw["max_weight"], what
        assert ("Drop", what) in orders(robot)
    assert (76, 1) == (len(taken), max(taken.values()))


def test_every_script_is_carried_out(world):
    """All robots do all that they have to in a quarter of an hour of virtual time."""
    simulator = Simulator(world)
    simulator.run()

    scripts = simulator.scripts.all
    assert dict.fromkeys(world.robots, ScriptState.DONE) == {name: script.state for name, script in scripts.items()}
    assert 600 < simulator.now < 900


def test_some_aisles_are_one_way(world):
    """Aisles are driven in one direction, main aisles in both, and all lanes have a limit."""
    ways = {(lane.from_, lane.to): lane.one_way for lane in world.lanes}

    assert (ways["a_1", "a_2"], ways["b_2", "b_1"], ways["a_south", "b_south"]) == (True, True, False)
    assert all(lane.speed_limit for lane in world.lanes)
