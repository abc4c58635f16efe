"""Robots learn to share work, each as a PettingZoo agent.

Asked in https://github.com/semitable/robotic-warehouse/issues/23.
"""

import pytest


def test_an_episode_with_eight_agents() -> None:
    """Each agent takes the nearest order, and the same seed gives the same episode."""
    pytest.importorskip("pettingzoo", reason="needs the extra gym")
    from hmrsim_gym import nearest, parallel_env  # noqa: PLC0415 - it needs the extra

    def episode(seed: int) -> float:
        env = parallel_env("warehouse_orders", horizon=300)
        observations, _ = env.reset(seed=seed)
        total = 0.0
        while env.agents:
            actions = {robot: nearest(seen) for robot, seen in observations.items()}
            observations, rewards, *_ = env.step(actions)
            total += sum(rewards.values())
        env.close()
        return total

    assert episode(1) == episode(1) < 0
