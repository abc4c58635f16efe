"""Baseline rules: each returns the action for an observation, and never waits while there is an order."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim_gym.observations import OrderFeature

if TYPE_CHECKING:
    from hmrsim_gym.observations import Array, Observation


def nearest(observation: Observation) -> int:
    """Return the action for the order whose item the robot reaches first."""
    return best(observation, -observation["orders"][:, OrderFeature.APPROACH])


def first_come(observation: Observation) -> int:
    """Return the action for the oldest order."""
    return best(observation, observation["orders"][:, OrderFeature.AGE])


def earliest_due(observation: Observation) -> int:
    """Return the action for the order that is due first."""
    return best(observation, -observation["orders"][:, OrderFeature.SLACK])


def best(observation: Observation, scores: Array, waiting: float | None = None) -> int:
    """Return the action for the order with the highest score, the first one if several are equal.

    Args:
        observation: The observation.
        scores: The score of each row of orders.
        waiting: The score of waiting; None to never wait.
    """
    wait = len(scores)
    count = int(observation["action_mask"][:wait].sum())
    if not count:
        return wait
    row = int(scores[:count].argmax())
    return wait if waiting is not None and waiting > scores[row] else row
