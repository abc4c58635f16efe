"""Rules to compare with: each returns the action for an observation, which is never to wait while there is an order."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim_gym.features import OrderFeature

if TYPE_CHECKING:
    from hmrsim_gym.features import Array, Observation


def nearest(observation: Observation) -> int:
    """Return the order whose item the robot reaches first."""
    return best(observation, -observation["orders"][:, OrderFeature.APPROACH])


def first_come(observation: Observation) -> int:
    """Return the order that came first."""
    return best(observation, observation["orders"][:, OrderFeature.AGE])


def earliest_due(observation: Observation) -> int:
    """Return the order that is due first."""
    return best(observation, -observation["orders"][:, OrderFeature.SLACK])


def best(observation: Observation, scores: Array, waiting: float | None = None) -> int:
    """Return the order with the best score, the first of equal ones.

    Args:
        observation: What the robot can know.
        scores: One for each row of orders.
        waiting: The score of waiting; None for never.
    """
    wait = len(scores)
    count = int(observation["action_mask"][:wait].sum())
    if not count:
        return wait
    row = int(scores[:count].argmax())
    return wait if waiting is not None and waiting > scores[row] else row
