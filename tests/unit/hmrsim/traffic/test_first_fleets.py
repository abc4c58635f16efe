"""Small random fleets serve all of their orders under `priority` and `planned`."""

from __future__ import annotations

import pytest

from benchmarks._dispatched import dispatched
from benchmarks.first_fleets import fleet

SEEDS = (6, 7, 10, 13, 22, 34, 45, 53, 57, 58, 66, 72, 80, 255, 371, 933, 957)
"""Fleets whose orders can all be served, each of which once showed a mistake of the policies."""


@pytest.mark.parametrize("policy", ["priority", "planned"])
@pytest.mark.parametrize("seed", SEEDS)
def test_a_plain_dispatcher_serves_every_order(seed, policy):
    outcome = dispatched(fleet(seed, policy))

    assert (outcome.total, [], []) == (outcome.served, outcome.touching, outcome.waiting)


@pytest.mark.parametrize("seed", SEEDS[:4])
def test_a_robot_that_is_given_up_names_the_last_cause_and_what_would_help(seed):
    """Under `reserve`, robots make no room."""
    outcome = dispatched(fleet(seed, "reserve"))
    blocked = [text for text in outcome.aborted if "blocked for" in text]

    assert blocked
    assert all(" since " in text and " is idle at " in text and "; what would help: " in text for text in blocked)
