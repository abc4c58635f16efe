"""The state machine of goals."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.protocol.goal import TRANSITIONS, GoalEvent, GoalStatus, IllegalTransition, next_status, parse_goal_id

LEGAL = {
    ("ACCEPTED", "EXECUTE"): "EXECUTING",
    ("ACCEPTED", "CANCEL"): "CANCELING",
    ("EXECUTING", "CANCEL"): "CANCELING",
    ("EXECUTING", "SUCCEED"): "SUCCEEDED",
    ("EXECUTING", "ABORT"): "ABORTED",
    ("CANCELING", "SUCCEED"): "SUCCEEDED",
    ("CANCELING", "ABORT"): "ABORTED",
    ("CANCELING", "CANCELED"): "CANCELED",
}


@pytest.mark.parametrize("status", GoalStatus)
@pytest.mark.parametrize("event", GoalEvent)
def test_transitions_are_those_of_rcl_action(status, event):
    expected = LEGAL.get((status.name, event.name))

    if expected is None:
        with pytest.raises(IllegalTransition, match=status.name):
            next_status(status, event)
    else:
        assert expected == next_status(status, event).name


def test_the_table_has_no_other_transitions():
    assert len(LEGAL) == len(TRANSITIONS)


@pytest.mark.parametrize(
    ("status", "number"),
    [
        ("UNKNOWN", 0),
        ("ACCEPTED", 1),
        ("EXECUTING", 2),
        ("CANCELING", 3),
        ("SUCCEEDED", 4),
        ("CANCELED", 5),
        ("ABORTED", 6),
    ],
)
def test_statuses_have_the_numbers_of_action_msgs(status, number):
    assert number == GoalStatus[status]


def test_only_accepted_and_executing_goals_are_cancelable():
    assert ["ACCEPTED", "EXECUTING"] == [status.name for status in GoalStatus if status.cancelable]


def test_three_statuses_are_terminal():
    assert ["SUCCEEDED", "CANCELED", "ABORTED"] == [status.name for status in GoalStatus if status.terminal]


@given(st.uuids())
def test_a_goal_id_may_have_hyphens_and_capitals(uuid):
    assert uuid.hex == parse_goal_id(str(uuid).upper()) == parse_goal_id(uuid.hex)


@pytest.mark.parametrize("text", ["", "abc", "g" * 32, "0" * 31, "0" * 33, "{" + "0" * 32 + "}", " " + "0" * 32])
def test_invalid_goal_ids_are_rejected(text):
    with pytest.raises(ValueError, match="is not a UUID of 32 hex digits"):
        parse_goal_id(text)
