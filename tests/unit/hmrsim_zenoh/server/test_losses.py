"""Losses of answers that a disturbance injects."""

from __future__ import annotations

from hmrsim_zenoh.server.losses import Losses


def test_as_many_answers_are_lost_as_are_asked_for():
    """Further requests for losses add up, and later answers arrive."""
    losses = Losses()
    before = losses.lost()
    losses.lose_answers(1)
    losses.lose_answers(1)

    assert not before
    assert [True, True, False, False] == [losses.lost() for _ in range(4)]
