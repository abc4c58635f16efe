"""The transition table of goals, row by row."""

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
def test_every_pair_of_status_and_event_is_as_rcl_action_has_it(status, event):
    """A pair in rcl's table leads where it says; every other pair is refused."""
    expected = LEGAL.get((status.name, event.name))

    if expected is None:
        with pytest.raises(IllegalTransition, match=status.name):
            next_status(status, event)
    else:
        assert expected == next_status(status, event).name


def test_the_table_has_no_row_beyond_rcl_action():
    """There are eight legal transitions."""
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
    """The numbers are those of action_msgs/msg/GoalStatus."""
    assert number == GoalStatus[status]


def test_only_accepted_and_executing_goals_are_cancelable():
    """A goal that is canceling may not be canceled again."""
    assert ["ACCEPTED", "EXECUTING"] == [status.name for status in GoalStatus if status.cancelable]


def test_three_statuses_are_terminal():
    """SUCCEEDED, CANCELED and ABORTED end a goal."""
    assert ["SUCCEEDED", "CANCELED", "ABORTED"] == [status.name for status in GoalStatus if status.terminal]


@given(st.uuids())
def test_a_goal_id_may_have_hyphens_and_capitals(uuid):
    """All spellings of a UUID are one id: 32 lower-case hex digits."""
    assert uuid.hex == parse_goal_id(str(uuid).upper()) == parse_goal_id(uuid.hex)


@pytest.mark.parametrize("text", ["", "abc", "g" * 32, "0" * 31, "0" * 33, "{" + "0" * 32 + "}", " " + "0" * 32])
def test_other_text_is_no_goal_id(text):
    """What is not 32 hex digits is refused, and shown."""
    with pytest.raises(ValueError, match="is not a UUID of 32 hex digits"):
        parse_goal_id(text)
