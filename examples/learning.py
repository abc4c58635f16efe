"""Learn which order a robot should serve, and compare what was learned with serving the nearest one.

The score of an order is linear in five features. The cross-entropy method looks for weights: it tries some around a
mean, and moves the mean to those that did best. It needs ``pip install 'hmrsim[gym,experiments]'``, and takes ten
seconds. The runs of the comparison have seeds that were not learned from.
"""

from collections.abc import Callable

import gymnasium
import numpy as np
from numpy.typing import NDArray

from hmrsim.experiments.statistics import Criterion, compare, paired_difference
from hmrsim_gym import OrderFeature, best, nearest

Observation = dict[str, NDArray]
Rule = Callable[[Observation], int]

GENERATIONS, TRIED, KEPT, RUNS = 3, 6, 2, 1
HANDLING = 0.3
"""Minutes that it takes to pick an item up and lay it down, about."""

env = gymnasium.make("hmrsim/Dispatch-v0", world="warehouse_orders", horizon=1800)


def features(observation: Observation) -> NDArray:
    """Return what counts for each order: (orders, 5), about as large as each other."""
    approach, trip, slack, priority, rival = observation["orders"][
        :, [OrderFeature.APPROACH, OrderFeature.TRIP, OrderFeature.SLACK, OrderFeature.PRIORITY, OrderFeature.RIVAL]
    ].T
    needed = approach + trip + HANDLING
    return np.stack([-approach, -trip, -np.minimum(slack - needed, 5), (1 + priority) / needed, -rival.clip(-1, 1)], 1)


def learned(weights: NDArray) -> Rule:
    """Return the rule to serve the order with the best score."""
    return lambda observation: best(observation, features(observation) @ weights)


def cost(rule: Rule, seed: int) -> float:
    """Return what the orders of a run cost."""
    observation, _ = env.reset(seed=seed)
    total, over = 0.0, False
    while not over:
        observation, reward, terminated, truncated, _ = env.step(rule(observation))
        total, over = total - reward, terminated or truncated
    return total


rng = np.random.default_rng(1)
mean, spread = np.array([1.0, 0.0, 0.0, 0.0, 0.0]), np.array([0.3, 0.3, 0.3, 0.1, 0.3])
for generation in range(GENERATIONS):
    seeds = [1000 + RUNS * generation + run for run in range(RUNS)]
    usual = np.array([cost(nearest, seed) for seed in seeds])
    tried = mean + spread * rng.standard_normal((TRIED, len(mean)))
    shares = [np.mean([cost(learned(weights), seed) for seed in seeds] / usual) for weights in tried]
    kept = tried[np.argsort(shares)[:KEPT]]
    mean, spread = kept.mean(axis=0), 0.8 * kept.std(axis=0) + 0.2 * spread
    print(f"generation {generation + 1}: the best of {TRIED} cost {min(shares):.0%} of what the nearest order does")

seeds = range(30)
before, after = [cost(nearest, seed) for seed in seeds], [cost(learned(mean), seed) for seed in seeds]
interval, verdict = paired_difference(before, after).interval, compare(before, after, Criterion(larger_is_better=False))
print(f"weights {mean.round(2)}")
print(f"{len(seeds)} other runs: the nearest order costs {np.mean(before):.0f}, the learned one {np.mean(after):.0f}")
print(f"the difference is {interval.estimate:.0f}, between {interval.low:.0f} and {interval.high:.0f} with 95 %")
print(f"the learned rule is {verdict.verdict}, which was known after {verdict.decided_after} pairs of runs")
