"""What people are told of events."""

from __future__ import annotations

import pytest

from hmrsim.cli.telling import text_of
from hmrsim.events.goals import GoalAccepted, GoalStatusChanged
from hmrsim.events.robots import Stopped
from hmrsim.events.traffic import Waiting


@pytest.mark.parametrize(
    ("event", "text"),
    [
        (Waiting("eve", (1.0, 2.0), for_=("ann", "bob")), "waits for ann and bob"),
        (GoalAccepted("eve", "wait", "1" * 32, {"time": {"sec": 5}}), "wait accepted: 5 s"),
        (GoalAccepted("eve", "wait", "1" * 32, {"time": "long"}), "wait accepted"),
        (GoalAccepted("eve", "juggle", "1" * 32, {"balls": 3}), "juggle accepted"),
        (GoalStatusChanged("eve", "wait", "1" * 32, 6, {"error_msg": "no"}), "wait ABORTED: no"),
        (GoalStatusChanged("eve", "wait", "1" * 32, 2), ""),
        (Stopped("eve", (1.0, 2.0)), ""),
    ],
)
def test_an_event_is_told_unless_it_is_for_debugging(event, text):
    """With what a goal asks for, where the action is known and its message can be read."""
    assert text == text_of(event)
