"""Patterns of events, and the errors of invalid ones."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from hmrsim.events import EventPattern
from hmrsim.events.goals import GoalStatusChanged, SendGoalRejected
from hmrsim.events.robots import ItemPicked
from hmrsim.events.traffic import LaneClosed


def ended(status: int, robot: str = "eve", action: str = "pickup") -> GoalStatusChanged:
    return GoalStatusChanged(robot, action, "0" * 32, status)


def test_a_pattern_matches_kind_and_fields():
    closed = LaneClosed(("home", "door"), "closed by a test")

    assert EventPattern(event="lane_closed").matches(closed)
    assert EventPattern(event="lane_closed", where={"lane": ["home", "door"]}).matches(closed)
    assert not EventPattern(event="lane_closed", where={"lane": ["door", "home"]}).matches(closed)
    assert not EventPattern(event="lane_opened").matches(closed)


def test_a_pattern_matches_only_its_robot():
    picked = ItemPicked("eve", "box")

    assert EventPattern(event="picked", robot="eve").matches(picked)
    assert not EventPattern(event="picked", robot="wall_e").matches(picked)


def test_a_pattern_matches_the_status_of_a_goal():
    pattern = EventPattern(goal="ended", robot="eve", action="pickup")

    assert [pattern.matches(ended(status)) for status in range(1, 7)] == [False, False, False, True, True, True]
    assert not pattern.matches(ended(4, robot="wall_e"))
    assert not pattern.matches(ended(4, action="place"))
    assert not pattern.matches(ItemPicked("eve", "box"))


def test_a_pattern_matches_a_rejected_goal():
    rejected = SendGoalRejected("eve", "pickup", "0" * 32, "not_ready", "it has broken down")

    assert EventPattern(goal="rejected", robot="eve").matches(rejected)
    assert not EventPattern(goal="aborted", robot="eve").matches(rejected)


def test_unknown_names_are_errors_that_list_the_known_ones():
    unknown = [finding.message for finding in EventPattern(event="pickd").flaws()]
    field = [finding.message for finding in EventPattern(event="picked", where={"itm": "box"}).flaws()]
    robot = [finding.message for finding in EventPattern(event="lane_closed", robot="eve").flaws()]

    assert unknown == ["there is no kind of event 'pickd'; did you mean 'picked'?"]
    assert field == ["picked has no field 'itm'; did you mean 'item'?"]
    assert robot == ["lane_closed is not about a robot"]


@pytest.mark.parametrize(
    ("said", "message"),
    [
        ({}, "expected either event: KIND or goal: STATUS"),
        ({"event": "picked", "goal": "ended"}, "expected either event: KIND or goal: STATUS"),
        ({"event": "picked", "action": "pickup"}, "action belongs to goal"),
        ({"goal": "ended", "where": {"robot": "eve"}}, "where belongs to event"),
    ],
)
def test_event_and_goal_exclude_each_other(said, message):
    with pytest.raises(ValidationError, match=message):
        EventPattern(**said)


def test_a_pattern_is_described_in_words():
    assert EventPattern(goal="accepted", robot="eve", action="pickup").describe() == "pickup of eve is accepted"
    assert EventPattern(event="picked", where={"item": "box"}).describe() == "picked (item box)"
