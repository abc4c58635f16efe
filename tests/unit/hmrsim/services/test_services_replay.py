"""Replays of runs in which services changed the world."""

from __future__ import annotations

import pytest

from hmrsim.protocol.commands import CancelGoal
from hmrsim.trace.replay import replay
from tests import simulation
from tests.simulation import C, send, simulate

WORLD = {
    "waypoints": {"zoo": [0, 0], "bar": [10, 0]},
    "lanes": [["zoo", "bar"]],
    "items": {"parcel": {"at": [0, 0.5], "weight": 0.2}},
    "robots": {"zed": {"type": "fetcher", "at": "zoo", "script": ["Grab parcel", "Go bar"]}, "ann": {"at": "bar"}},
}


def go(robot, x):
    return simulation.go(x, 0.0, None, robot)


def steps(number):
    return send("simulate_steps", C, "_world", steps=number)


def state(number):
    return ("set_simulation_state", {"state": {"state": number}})


PAUSE, PLAY, STOP = state(2), state(1), state(0)
SPAWN = (
    "spawn_entity",
    {"name": "new", "uri": "robot_type:fetcher", "initial_pose": {"pose": {"position": {"x": 4.0}}}},
)

STORIES = {
    "pause": [(1.3, PAUSE), (0.0, go("ann", 2.0)), (0.0, PLAY), (2.0, go("ann", 3.0))],
    "step": [(1.3, PAUSE), (0.0, go("ann", 2.0)), (0.0, ("step_simulation", {"steps": 7})), (3.0, PLAY)],
    "steps": [(0.5, PAUSE), (0.0, steps(5)), (0.25, CancelGoal("_world", "simulate_steps", C)), (0.0, PLAY)],
    "spawn": [(1.0, SPAWN), (0.0, go("new", 0.0)), (1.0, ("delete_entity", {"entity": "new"})), (1.0, SPAWN)],
    "delete": [(2.0, ("delete_entity", {"entity": "zed"})), (1.0, ("delete_entity", {"entity": "parcel"}))],
    "move": [(2.0, ("set_entity_state", {"entity": "zed", "state": {"pose": {"position": {"x": 1.0}}}}))],
    "reset": [(2.0, SPAWN), (1.0, ("reset_simulation", {})), (3.0, go("ann", 3.0))],
    "reset of time": [(2.0, ("reset_simulation", {"scope": 1})), (1.0, go("ann", 3.0))],
    "reset of the state": [(2.0, ("reset_simulation", {"scope": 2})), (1.0, go("ann", 3.0))],
    "stop": [(2.0, STOP), (0.0, go("ann", 3.0)), (0.0, PLAY)],
    "load": [(2.0, ("load_world", {"uri": "scenario1"})), (0.0, PLAY), (1.0, ("get_entities", {}))],
    "load in vain": [(2.0, ("load_world", {"uri": "no_such_world"})), (1.0, go("ann", 3.0))],
}


def play(story, **settings):
    """Return the trace of a run; each command comes some seconds after the one before."""
    run = simulate(WORLD, topics=frozenset(), traced=True, **settings)
    for after, what in story:
        run.simulator.advance(run.simulator.now + after)
        if isinstance(what, tuple) and isinstance(what[0], str) and isinstance(what[1], dict):
            run.ask(*what)
        else:
            run.simulator.submit(what)
    run.simulator.run()
    run.simulator.stop()
    return "".join(run.lines())


@pytest.mark.parametrize("story", STORIES.values(), ids=STORIES)
def test_a_replay_equals_the_original(story):
    outcome = replay(play(story).splitlines(keepends=True))

    assert None is outcome.difference
    assert outcome.complete


def test_a_replay_makes_steps_of_the_same_size():
    outcome = replay(play(STORIES["step"], step_size=0.3).splitlines(keepends=True))

    assert None is outcome.difference


def test_a_replay_needs_no_file_of_a_loaded_world():
    assert r"\"scenario 1\"" in play(STORIES["load"])


def test_queries_and_failed_loads_are_not_traced():
    assert "no_such_world" not in play(STORIES["load in vain"])
    assert "get_entities" not in play(STORIES["load"])
