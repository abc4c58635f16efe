"""Goals that cancel_goal selects, and its answers, by the rules of rcl."""

from __future__ import annotations

import pytest

A, B, C = (letter * 32 for letter in "abc")
WAIT = "wall_e/wait"
ROBOTS = {"robots": {"one": {"at": [0, 0]}, "two": {"at": [1, 0]}}}


@pytest.fixture
def running(serve):
    """Return three goals of one action that run at once, which no real action of the small world allows."""
    from dataclasses import replace  # noqa: PLC0415

    from hmrsim.actions import registry  # noqa: PLC0415

    free = {**registry(), "wait": replace(registry()["wait"], holds_base=False)}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("hmrsim.simulation.simulator.installed_actions", lambda: free)
        tester = serve(real_time_factor=1.0)
    # No goal is accepted at 0, which is before all times that a cancel can name.
    while tester.one("_world/clock")["clock"] == {"sec": 0, "nanosec": 0}:
        pass
    stamps = [tester.send(WAIT, {"time": {"sec": 1000}}, goal_id)["stamp"] for goal_id in (A, B, C)]
    return tester, stamps


def ids(answer):
    """Return the ids of the goals that are being canceled."""
    return [goal["goal_id"] for goal in answer["goals_canceling"]]


def test_one_goal_is_canceled_by_its_id_and_listed_with_its_stamp(running):
    tester, stamps = running

    answer = tester.cancel(WAIT, B)

    assert {"return_code": 0, "goals_canceling": [{"goal_id": B, "stamp": stamps[1]}]} == answer
    assert [(A, 2), (B, 5), (C, 2)] == tester.status(WAIT)


def test_goals_accepted_up_to_a_time_are_canceled(running):
    tester, stamps = running

    answer = tester.cancel(WAIT, stamp=stamps[1])

    assert (0, [A, B]) == (answer["return_code"], ids(answer))
    assert [(A, 5), (B, 5), (C, 2)] == tester.status(WAIT)


@pytest.mark.parametrize(
    "payload",
    [
        {},
        {"goal_info": {}},
        {"goal_info": {"goal_id": "0" * 32, "stamp": {"sec": 0, "nanosec": 0}}},
        {"goal_info": {"goal_id": "00000000-0000-0000-0000-000000000000"}},
    ],
)
def test_without_id_and_time_all_goals_are_canceled(running, payload):
    tester, _ = running

    answer = tester.one(f"{WAIT}/_action/cancel_goal", payload)

    assert (0, [A, B, C]) == (answer["return_code"], ids(answer))


def test_the_id_may_have_hyphens(running):
    tester, _ = running

    assert [A] == ids(tester.cancel(WAIT, "AAAAAAAA-AAAA-AAAA-AAAA-AAAAAAAAAAAA"))


def test_a_cancel_right_behind_its_goal_does_not_overtake_it(serve):
    """Many pairs of requests are sent without waiting, while samples keep the simulation busy."""
    tester = serve(ROBOTS, real_time_factor=100_000.0)
    tester.hear("_world/clock")
    pending = []
    for number in range(1, 301):
        goal_id = f"{number:032x}"
        tester.begin("one/wait/_action/send_goal", {"goal_id": goal_id, "goal": {"time": {"sec": 100_000_000}}})
        pending.append(tester.begin("one/wait/_action/cancel_goal", {"goal_info": {"goal_id": goal_id}}))

    assert [0] * 300 == [replies.one()["return_code"] for replies in pending]
