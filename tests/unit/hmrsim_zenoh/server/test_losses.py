"""Answers that get lost on purpose."""

from __future__ import annotations

from hmrsim_zenoh.server.losses import Losses


def test_as_many_answers_are_lost_as_are_asked_for():
    """None before, and none after; what is asked for again adds up."""
    losses = Losses()
    before = losses.lost()
    losses.lose_answers(1)
    losses.lose_answers(1)

    assert not before
    assert [True, True, False, False] == [losses.lost() for _ in range(4)]
