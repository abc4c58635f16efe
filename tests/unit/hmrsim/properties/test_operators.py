"""Properties by operators: their violations, undecided cases, and robustness."""

from __future__ import annotations

import pytest

from hmrsim.properties import Ended
from tests.watching import Feed, seconds, ward

GO = "navigate_to_pose"
A, B = "a" * 32, "b" * 32
DOOR = {"event": "door_opened"}
IN_TIME = {
    "whenever": {"event": "order_placed"},
    "then": {"event": "order_delivered", "where": {"order": "$order"}},
    "within": 60,
}
RETRIES = {
    "whenever": {"goal": "aborted", "robot": "*", "action": GO},
    "then": {"goal": "accepted", "robot": "$robot"},
    "within": 30,
}
STOPS = {
    "whenever": {"event": "fault_began", "where": {"fault": "breakdown"}},
    "then": {"robot": "$robot", "is": "stopped"},
}


def watched(said, **world):
    """Return a monitor of one property that has started at 0."""
    feed = Feed({"p": said}, world=ward(**world) if world else None)
    feed.monitor.begin(0)
    return feed


def low(feed, at, robot, share):
    """Feed the level of a battery."""
    return feed.event(at, "battery_low", robot=robot, charge=1.0, percentage=share)


def place(feed, at, order):
    return feed.event(at, "order_placed", order=order, item=order, **{"from": "lab", "to": "ward_a"})


def deliver(feed, at, order):
    return feed.event(at, "order_delivered", order=order, item=order, lead_time=1.0)


def test_always_is_violated_at_each_end_of_its_condition():
    feed = watched({"always": {"battery": "eve", "above": 0.3}})
    for at, share in ((5, 0.2), (6, 0.1), (7, 0.5), (8, 0.25)):
        low(feed, at, "eve", share)

    assert [
        (5.0, "p", "eve", "not: the battery of eve is above 30%"),
        (8.0, "p", "eve", "not: the battery of eve is above 30%"),
    ] == feed.end(9).violations


def test_the_robustness_of_always_is_the_least_distance():
    """A battery at 40 % at least is a tenth above its limit of 30 %."""
    verdict = low(watched({"always": {"battery": "eve", "above": 0.3}}), 5, "eve", 0.4).end(9).verdict("p")

    assert ("holds", pytest.approx(0.1)) == verdict[1:3]


def test_a_star_stands_for_each_robot_separately():
    feed = watched({"always": {"battery": "*", "above": 0.3}})
    low(low(feed, 5, "wall_e", 0.2), 6, "eve", 0.1).end(9)

    reason = "not: the battery of each robot is above 30%"
    assert [(5.0, "p", "wall_e", reason), (6.0, "p", "eve", reason)] == feed.violations


def test_a_spawned_robot_is_watched_as_well():
    feed = watched({"never": {"robot": "*", "at": "hall"}}, robots={"cart": {"at": "lab"}})
    feed.event(5, "spawned", entity="late", type="carrier", at=[10.0, 0.0]).end(9)

    assert [(5.0, "p", "late", "each robot is at hall")] == feed.violations


def test_never_is_violated_by_each_event():
    feed = watched({"never": DOOR})
    for at in (3, 7):
        feed.event(at, "door_opened", door="gate")

    assert [3.0, 7.0] == [each[0] for each in feed.end(9).violations]


def test_a_violation_by_an_event_names_its_robot_place_and_time():
    feed = watched({"never": {"event": "battery_empty"}})
    for robot, at in (("eve", (1.0, 2.0)), ("wall_e", (3.0, 4.0))):
        feed.event(5, "battery_empty", robot=robot, at=at, charge=0.0, percentage=0.0)
    violation = feed.end(9).monitor.violations[0]

    events = "eve has an empty battery at (1, 2), wall_e has an empty battery at (3, 4)"
    assert ("eve", f"battery_empty, at 5 s: {events}") == (violation.subject, violation.text)


def test_eventually_within_some_time_is_violated_when_it_is_over():
    """It is violated even if the condition holds later."""
    feed = watched({"eventually": DOOR, "within": 10}).event(11, "door_opened", door="gate").end(20)

    assert [(10.0, "p", "", "not within 10 s: door_opened")] == feed.violations


def test_eventually_at_its_last_instant_is_in_time():
    verdict = watched({"eventually": DOOR, "within": 10}).event(10, "door_opened", door="gate").end(20).verdict("p")

    assert ("holds", 0.0) == verdict[1:3]


def test_a_window_that_the_end_cuts_off_is_undecided():
    feed = watched({"eventually": DOOR, "within": 10}).end(8)

    assert ([], "undecided") == (feed.violations, feed.verdict("p").state)


def test_eventually_without_a_limit_is_violated_at_the_end():
    feed = watched({"eventually": DOOR}).end(8)

    assert [(8.0, "p", "", "never: door_opened")] == feed.violations


def test_eventually_is_undecided_in_a_stopped_run():
    feed = watched({"eventually": DOOR}).end(8, "stopped")

    assert ([], "undecided") == (feed.violations, feed.verdict("p").state)


def test_sometimes_is_counted_and_never_violated():
    never, twice = watched({"sometimes": DOOR}).end(8), watched({"sometimes": DOOR})
    twice.event(1, "door_opened", door="gate").event(1, "door_opened", door="gate").end(8)

    assert ("never_exercised", "door_opened, 2 times") == (never.verdict("p").state, twice.verdict("p").text)


def test_each_trigger_needs_its_own_response():
    """The delivery of one order does not stand for another."""
    feed = watched(IN_TIME)
    deliver(place(place(feed, 5, "a"), 6, "b"), 30, "a").end(99)

    assert [(66.0, "p", "b", "not within 60 s: order_delivered (order $order)")] == feed.violations


def test_the_robustness_of_responses_is_the_least_time_left():
    """Of 60 s, one response took 15 and another 45."""
    feed = watched(IN_TIME)
    deliver(deliver(place(place(feed, 0, "a"), 0, "b"), 15, "a"), 45, "b")

    assert ("holds", 0.25) == feed.end(99).verdict("p")[1:3]


def test_a_trigger_that_the_end_cuts_off_is_undecided():
    feed = place(watched(IN_TIME), 50, "a").end(99)

    assert ([], "undecided") == (feed.violations, feed.verdict("p").state)


def test_a_property_without_a_trigger_is_not_exercised():
    assert "never_exercised" == watched(IN_TIME).end(9).verdict("p").state


def test_an_event_before_its_trigger_at_the_same_instant_is_no_response():
    """A goal aborted at once is not its own retry."""
    feed = watched(RETRIES).goal(5, "eve", GO, A, 1, 2, 6).goal(9, "wall_e", GO, B, 1)

    assert [(35.0, "p", "eve", "not within 30 s: a goal of $robot is accepted")] == feed.end(99).violations


def test_an_event_after_its_trigger_at_the_same_instant_is_a_response():
    feed = watched(RETRIES).goal(5, "eve", GO, A, 1, 2, 6).goal(5, "eve", GO, B, 1).end(99)

    assert ([], "holds") == (feed.violations, feed.verdict("p").state)


def test_a_response_can_be_a_state_of_the_triggers_robot():
    feed = watched({**STOPS, "within": 1})
    feed.event(5, "fault_began", fault="breakdown", name="b", robot="eve")
    feed.event(6, "fault_began", fault="slip", name="s", robot="wall_e").end(9)

    assert ([], "holds") == (feed.violations, feed.verdict("p").state)


def test_a_missing_state_is_reported_with_its_robot():
    feed = watched({"whenever": {"event": "picked"}, "then": {"robot": "$robot", "at": "ward_a"}, "within": 30})
    feed.event(5, "picked", robot="eve", item="medicine").event(6, "picked", robot="wall_e", item="x")
    feed.event(20, "teleported", entity="wall_e", at=[20.0, 0.0], yaw=0.0).end(99)

    assert [(35.0, "p", "eve", "not within 30 s: $robot is at ward_a")] == feed.violations


def test_a_response_can_use_the_triggers_place_and_item():
    """A place that does not exist is never reached."""
    arrives = {"whenever": {"event": "order_placed"}, "then": {"item": "$item", "at": "$to"}, "within": 60}
    feed = place(place(watched(arrives), 5, "a"), 6, "b")
    feed.event(7, "order_placed", order="c", item="c", **{"from": "lab", "to": "nowhere"})
    for at, item in ((20, "a"), (30, "c")):
        feed.event(at, "placed", robot="eve", item=item, at=[20.0, 0.0])

    assert [(66.0, "b"), (67.0, "c")] == [(at, subject) for at, _, subject, _ in feed.end(99).violations]


def test_a_response_can_be_the_battery_of_the_triggers_robot():
    full = {"whenever": {"event": "charging_began"}, "then": {"battery": "$robot", "above": 0.9}, "within": 60}
    feed = watched(full)
    for robot in ("eve", "wall_e"):
        feed.event(2, "charging_began", robot=robot, charge=1.0, percentage=0.2)
    low(feed, 30, "eve", 0.95)

    assert [(62.0, "wall_e")] == [(at, subject) for at, _, subject, _ in feed.end(99).violations]


def test_a_state_triggers_when_it_begins_to_hold():
    feed = watched({"whenever": {"robot": "wall_e", "at": "lab"}, "then": DOOR, "within": 10})
    feed.event(5, "teleported", entity="wall_e", at=[0.0, 0.0], yaw=0.0).event(5, "door_opened", door="gate")
    feed.event(6, "teleported", entity="wall_e", at=[10.0, 0.0], yaw=0.0)
    feed.event(7, "teleported", entity="wall_e", at=[0.0, 0.0], yaw=0.0).end(99)

    assert [(17.0, "p", "wall_e", "not within 10 s: door_opened")] == feed.violations


def test_a_response_without_a_limit_is_due_at_the_end():
    feed = watched({**STOPS, "then": DOOR}).event(5, "fault_began", fault="breakdown", name="b", robot="eve").end(50)

    assert [(50.0, "p", "eve", "never: door_opened")] == feed.violations


def test_violations_are_reported_as_soon_as_they_are_found():
    feed, told = watched(IN_TIME), []
    feed.monitor.subscribe(lambda violation: told.append((violation.property, violation.at)))
    place(feed, 5, "a").event(65, "door_opened", door="gate")

    assert [] == told
    feed.event(66, "door_opened", door="gate")

    assert [("p", seconds(65))] == told


def test_events_after_the_end_are_ignored():
    feed = watched({"never": DOOR}).end(8).event(9, "door_opened", door="gate")
    feed.monitor.timeline.restart(seconds(99))
    feed.monitor.end(None, Ended("failed"))

    assert [] == feed.violations


def test_an_event_at_the_instant_of_its_triggering_state_is_a_response():
    """A condition starts to hold at the end of an instant."""
    feed = watched({"whenever": {"all": [DOOR, {"fault": "slip"}]}, "then": {"event": "door_closed"}, "within": 5})
    feed.event(1, "fault_began", fault="slip", name="s", robot="eve")
    feed.event(2, "door_closed", door="gate").event(2, "door_opened", door="gate").event(3, "door_opened", door="gate")

    assert [(8.0, "not within 5 s: door_closed")] == [(at, why) for at, _, _, why in feed.end(20).violations]


def test_a_run_that_was_stopped_leaves_obligations_undecided():
    feed = watched({**STOPS, "then": DOOR}).event(5, "fault_began", fault="breakdown", name="b", robot="eve")

    assert "undecided" == feed.end(50, "stopped").verdict("p").state


def test_a_property_of_each_robot_is_exercised_by_any():
    """A property of `sometimes` has to hold for each robot."""
    retried = watched(RETRIES).goal(5, "eve", GO, A, 1, 2, 6).goal(9, "eve", GO, B, 1).end(99)
    happened = watched({"sometimes": {"goal": "accepted", "robot": "*"}}).goal(9, "eve", GO, B, 1).end(99)

    assert ["holds", "never_exercised"] == [feed.verdict("p").state for feed in (retried, happened)]
