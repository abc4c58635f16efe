"""A corridor with orders, and functions that make environments of it."""

from __future__ import annotations

import copy

import pytest

WORLD = {
    "waypoints": {"store": [0, 0], "door": [10, 0], "ward": [20, 0]},
    "lanes": [["store", "door"], ["door", "ward"]],
    "traffic": {"policy": "free"},
    "robots": {
        "wall_e": {"at": "store", "components": {"claw": {"max_weight": 5}}},
        "eve": {"at": "ward", "components": {"claw": {"max_weight": 5}}},
        "cart": {"at": "door"},
    },
    "demand": [{"name": "parcel", "at": ["store", "door"], "to": "ward", "arrives": 15, "within": 60, "count": 4}],
}


@pytest.fixture
def world():
    """Return a corridor as plain values, in which two robots serve four orders."""
    return copy.deepcopy(WORLD)


@pytest.fixture
def make():
    """Return a function that makes an environment, which is closed after the test."""
    gymnasium = pytest.importorskip("gymnasium", reason="environments need the extra gym")
    made = []

    def environment(world, **arguments):
        env = gymnasium.make("hmrsim_gym:hmrsim/Dispatch-v0", world=world, **arguments)
        made.append(env)
        return env

    yield environment
    for env in made:
        env.close()


@pytest.fixture
def make_parallel():
    """Return a function that makes a parallel environment, which is closed after the test."""
    hmrsim_gym = pytest.importorskip("hmrsim_gym.parallel", reason="environments need the extra gym")
    made = []

    def environment(world, **arguments):
        env = hmrsim_gym.parallel_env(world, **arguments)
        made.append(env)
        return env

    yield environment
    for env in made:
        env.close()
