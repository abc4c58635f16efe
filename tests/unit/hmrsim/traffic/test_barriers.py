"""Doors and lifts on the lanes by which robots make room for each other."""

from __future__ import annotations

import pytest

from hmrsim.protocol.commands import CallService
from hmrsim.services import registry as services
from tests.simulation import simulate
from tests.unit.hmrsim.traffic.runs import go

A, B = "a" * 32, "b" * 32
JUNCTION = {
    "waypoints": {"a": [0, 0], "b": [10, 0], "c": [20, 0], "bay": [10, 5]},
    "lanes": [["a", "b"], ["b", "c"]],
    "robots": {"ann": {"at": "a"}, "bob": {"at": "c"}},
}
ARM = [*JUNCTION["lanes"], ["b", "bay"]]
ACROSS = {"at": [[9, 2.5], [11, 2.5]]}
STOPS = {**JUNCTION["waypoints"], "b": {"at": [10, 0], "capacity": 1}}
SIDES = {
    "open": {"lanes": ARM, "doors": {"door": {**ACROSS, "open": True}}},
    "automatic": {"lanes": ARM, "doors": {"door": ACROSS}},
    "at once": {"lanes": ARM, "doors": {"door": {**ACROSS, "opening_time": 0.0, "stays_open": 0.0}}},
    "twice": {"lanes": ARM, "doors": {"door": ACROSS, "inner": {"at": [[9, 4], [11, 4]], "opening_time": 7.0}}},
    "for one": {"lanes": ARM, "doors": {"door": {**ACROSS, "opens_for": ["ann"]}}},
    "for the other": {"lanes": ARM, "doors": {"door": {**ACROSS, "opens_for": ["bob"]}}},
    "lift": {"lifts": {"lift": {"stops": ["b", "bay"]}}, "waypoints": STOPS},
    "lift elsewhere": {"lifts": {"lift": {"stops": ["bay", "b"]}}, "waypoints": STOPS},
}


def order(door, state):
    """Return the command that opens, closes or locks a door."""
    service = services()["set_door_state"]
    return CallService("set_door_state", service.request.model_validate({"name": door, "state": state}), object())


def meet(policy, side, *commands, **more):
    """Return the log of two robots that meet at a junction and want to change places."""
    run = simulate({**JUNCTION, **SIDES[side], **more, "traffic": {"policy": policy, "patience": None}})
    return run((0.0, go("ann", 20, 0, A)), (0.0, go("bob", 0, 0, B)), *commands, until=300.0)


def ends(log):
    return [log.changes(goal_id)[-1][1] for goal_id in (A, B)]


@pytest.mark.parametrize(
    ("policy", "side"),
    [("priority", side) for side in SIDES] + [("reserve", side) for side in SIDES if side != "for the other"],
)
def test_a_robot_can_make_room_behind_a_door_or_in_a_lift(policy, side):
    log = meet(policy, side)

    assert ["SUCCEEDED"] * 2 == ends(log)


@pytest.mark.parametrize("policy", ["reserve", "priority"])
def test_a_door_stays_open_for_a_robot_that_makes_room(policy):
    log = meet(policy, "at once")
    (made_room, _), *_ = log.happened("made_room")
    (closed, _), *_ = log.happened("door_closed")

    assert made_room + 5.0 <= closed


@pytest.mark.parametrize("policy", ["reserve", "priority"])
@pytest.mark.parametrize("side", ["automatic", "twice"])
def test_a_circle_is_one_deadlock_until_it_is_dissolved(policy, side):
    """It is checked again each time that a door has opened."""
    log = meet(policy, side)

    assert [10.0] == [at for at, _ in log.happened("deadlock")]


@pytest.mark.parametrize("policy", ["reserve", "priority"])
def test_robots_do_not_make_room_behind_a_door_locked_meanwhile(policy):
    log = meet(policy, "automatic", (11.0, order("door", "locked")))

    assert 1 == ends(log).count("ABORTED")


def test_a_change_of_a_waits_cause_is_reported():
    door = {"at": [[4, -1], [4, 1]], "opening_time": 4.0}
    run = simulate({**JUNCTION, "lanes": ARM, "doors": {"door": door}, "traffic": {"policy": "reserve"}})
    log = run((0.0, go("ann", 10, 5, A)), (0.0, go("bob", 10, 0, B)), until=20.0)
    told = [(at, event.get("why") or event["for"]) for at, event in log.happened("waiting")]

    assert [(0.0, "door is opening"), (4.0, ["bob"])] == told


@pytest.mark.parametrize("policy", ["reserve", "priority"])
def test_a_lift_is_called_once_for_a_robot_that_makes_room(policy):
    """The policy requests it again while the cabin comes."""
    log = meet(policy, "lift elsewhere")
    (called, _), *_ = log.happened("lift_called")
    (left, empty), (carries, carried), *_ = log.happened("lift_departed")

    assert [called, [], ["ann"]] == [left, empty["robots"], carried["robots"]]
    assert called + 9.0 == carries
    assert 1 == len(log.happened("lift_called"))
