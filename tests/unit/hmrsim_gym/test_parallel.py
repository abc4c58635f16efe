"""The PettingZoo environment: its interface, and the decisions of its agents."""

from __future__ import annotations

import pytest

pytest.importorskip("pettingzoo", reason="environments need the extra gym")

from pettingzoo.test import parallel_api_test, parallel_seed_test

from hmrsim_gym import nearest

WAIT = 8


def test_passes_the_interface_test_of_pettingzoo(make_parallel, world):
    parallel_api_test(make_parallel(world), num_cycles=50)


def test_passes_the_seed_test_of_pettingzoo(make_parallel, world):
    parallel_seed_test(lambda: make_parallel(world), num_cycles=20)


def test_agents_without_a_decision_can_only_wait(make_parallel, world):
    env = make_parallel(world)
    env.reset(seed=1)

    *_, infos = env.step({"wall_e": 0, "eve": WAIT})

    assert [[0] * 8 + [1], [1] + [0] * 7 + [1]] == [infos[robot]["action_mask"].tolist() for robot in ("wall_e", "eve")]


def test_the_first_of_two_robots_gets_the_order(make_parallel, world):
    """The other robot waits until the next order arrives."""
    env = make_parallel(world)
    env.reset(seed=1)

    *_, infos = env.step({"wall_e": 0, "eve": 0})

    assert (30.0, [], ["parcel_2"]) == (infos["eve"]["now"], infos["wall_e"]["orders"], infos["eve"]["orders"])


def test_agents_share_the_reward_and_end_together(make_parallel, world):
    env = make_parallel(world)
    observations, _ = env.reset(seed=1)
    told = []
    while env.agents:
        actions = {robot: nearest(observations[robot]) for robot in env.agents}
        observations, rewards, terminated, truncated, _ = env.step(actions)
        told.append(set(rewards.values()))

    assert {1} == {len(rewards) for rewards in told}
    assert ({"wall_e": True, "eve": True}, {"wall_e": False, "eve": False}) == (terminated, truncated)


def test_state_has_the_observations_of_all_agents(make_parallel, world):
    env = make_parallel(world)
    observations, _ = env.reset(seed=1)

    assert sum(part.size for each in observations.values() for part in each.values()) == env.state().size


def test_step_needs_an_episode(make_parallel, world):
    with pytest.raises(ValueError, match="call reset first"):
        make_parallel(world).step({})
