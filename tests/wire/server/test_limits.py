"""Limits of messages from clients."""

from __future__ import annotations

import json

import pytest

from hmrsim_zenoh.wire.envelopes import MAX_TEXT
from hmrsim_zenoh.wire.session import MAX_MESSAGE

A = "a" * 32
GO = "wall_e/navigate_to_pose/_action/send_goal"


def goal(text):
    """Return a request that names a behavior tree."""
    return {"goal_id": A, "goal": {"behavior_tree": text}}


def test_a_text_that_is_too_long_is_refused(serve):
    """It would be repeated in answers, the log and the trace."""
    tester = serve()
    (reply,) = tester.ask(GO, goal("x" * (MAX_TEXT + 1)))

    assert not reply.ok
    assert "goal.behavior_tree: a text of 4097 characters; at most 4096 are taken" == reply.body["error"]
    assert 1_000 > len(json.dumps(reply.body))


def test_a_text_of_the_greatest_length_is_taken(serve):
    (reply,) = serve().ask(GO, goal("x" * MAX_TEXT))

    assert reply.ok


@pytest.mark.parametrize("length", [MAX_TEXT + 1, 100_000])
def test_the_text_of_a_world_may_be_longer(serve, length):
    (reply,) = serve().ask("_world/load_world", {"resource_string": "#" * length})

    assert reply.ok


def test_a_message_that_is_far_too_large_is_dropped_and_others_are_answered(serve):
    tester = serve()
    key = tester.key(GO)

    assert [] == [reply for reply in tester.session.get(key, payload=bytes(2 * MAX_MESSAGE), timeout=0.5) if reply.ok]
    assert tester.one("wall_e/odom")
