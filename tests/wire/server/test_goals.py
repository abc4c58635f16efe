"""Requests to send and cancel goals and for their results, and the answers."""

from __future__ import annotations

import pytest

from hmrsim_zenoh.server.inbox import ChannelInbox

A, B = "a" * 32, "b" * 32
NAVIGATE = "wall_e/navigate_to_pose"
WAIT = "wall_e/wait"


def test_an_accepted_goal_is_answered_with_its_id_and_stamp(fast, go):
    """A stamp of zero would mean unset, so at time zero it is one nanosecond."""
    (reply,) = fast.ask(f"{NAVIGATE}/_action/send_goal", {"goal_id": A, "goal": go(9, 2)})

    assert {"accepted": True, "goal_id": A, "stamp": {"sec": 0, "nanosec": 1}} == reply.body
    assert (True, "hmrsim/wall_e/navigate_to_pose/_action/send_goal") == (reply.ok, reply.key)


def test_what_is_sent_after_an_answer_is_accepted_later(live, wait):
    """Time passes between an answer and the next request, so no two stamps are equal."""
    stamps = [live.send(WAIT, wait(1000))["stamp"] for _ in range(100)]

    times = [(stamp["sec"], stamp["nanosec"]) for stamp in stamps]
    assert sorted(set(times)) == times


def test_an_id_may_have_hyphens_and_capitals(fast, go):
    """Both forms name the same goal, and the answer has neither."""
    answer = fast.send(NAVIGATE, go(5, 2), "AAAAAAAA-AAAA-AAAA-AAAA-AAAAAAAAAAAA")

    assert (True, A) == (answer["accepted"], answer["goal_id"])
    assert 4 == fast.result(NAVIGATE, "aaaaaaaa-AAAA-aaaa-aaaa-aaaaaaaaaaaa")["status"]


@pytest.mark.parametrize(
    ("name", "goal_id", "code", "text"),
    [(NAVIGATE, "not-a-uuid", 1, "'not-a-uuid' is not a UUID"), ("wall_e/pickup", "0" * 32, 99999, "zero")],
)
def test_a_rejected_goal_is_answered_with_reason_code_and_text(shared, name, goal_id, code, text):
    (reply,) = shared.ask(f"{name}/_action/send_goal", {"goal_id": goal_id, "goal": {}})

    answer = reply.body
    assert (False, goal_id, "invalid_goal_id") == (answer["accepted"], answer["goal_id"], answer["reason"])
    assert (code, True) == (answer["error_code"], text in answer["error_msg"])


def test_the_answer_to_a_used_id_has_the_status_of_its_goal(live, wait):
    first = live.send(WAIT, wait(1000), A)

    again = live.send(WAIT, wait(1000), A)

    assert ("duplicate_goal_id", 2, first["stamp"]) == (again["reason"], again["status"], again["stamp"])


@pytest.fixture
def crowded(serve, wait, monkeypatch):
    """Return a client of a busy simulator in which no request may wait."""
    monkeypatch.setitem(ChannelInbox.__init__.__kwdefaults__, "max_waiting", 0)
    tester = serve(real_time_factor=1.0)
    tester.send(WAIT, wait(1000), A)
    return tester


@pytest.mark.parametrize(("name", "code"), [("eve/wait", 1), ("eve/pickup", 99999)])
def test_a_goal_is_answered_busy_when_too_many_wait(crowded, name, code):
    answers = (crowded.send(name, {}) for _ in range(1000))

    busy = next(answer for answer in answers if not answer["accepted"])

    assert ("busy", code, "too many requests are waiting; try again later") == (
        busy["reason"],
        busy["error_code"],
        busy["error_msg"],
    )


def test_other_requests_get_an_error_when_too_many_wait(crowded):
    """Their responses have no field for it."""
    answers = (crowded.one("wall_e/wait/_action/get_result", {"goal_id": B}) for _ in range(1000))

    assert "too many requests are waiting; try again later" == next(a["error"] for a in answers if "error" in a)


@pytest.mark.parametrize(
    "goal_info",
    [
        None,
        {},
        {"goal_id": A},
        {"goal_id": "AAAAAAAA-AAAA-AAAA-AAAA-AAAAAAAAAAAA"},
        {"goal_id": "0" * 32, "stamp": {"sec": 0, "nanosec": 0}},
        {"goal_id": "00000000-0000-0000-0000-000000000000"},
        {"stamp": {"sec": 1000, "nanosec": 0}},
    ],
)
def test_a_cancel_names_a_goal_or_a_time_or_all(live, wait, goal_info):
    stamp = live.send(WAIT, wait(1000), A)["stamp"]

    answer = live.one(f"{WAIT}/_action/cancel_goal", {} if goal_info is None else {"goal_info": goal_info})

    assert {"return_code": 0, "goals_canceling": [{"goal_id": A, "stamp": stamp}]} == answer
    assert [(A, 5)] == live.status(WAIT)


def test_a_cancel_right_behind_its_goal_does_not_overtake_it(serve):
    """Many pairs of requests are sent without waiting, while samples keep the simulation busy."""
    tester = serve({"robots": {"one": {"at": [0, 0]}}}, real_time_factor=100_000.0)
    tester.hear("_world/clock")
    pending = []
    for number in range(1, 301):
        goal_id = f"{number:032x}"
        tester.begin("one/wait/_action/send_goal", {"goal_id": goal_id, "goal": {"time": {"sec": 100_000_000}}})
        pending.append(tester.begin("one/wait/_action/cancel_goal", {"goal_info": {"goal_id": goal_id}}))

    assert [0] * 300 == [replies.one()["return_code"] for replies in pending]


def test_a_result_request_is_held_until_the_goal_has_ended_for_each_client(live, wait):
    live.send(WAIT, wait(1000), A)
    held = [live.begin(f"{WAIT}/_action/get_result", {"goal_id": A}) for _ in range(3)]

    live.cancel(WAIT, A)

    assert [5, 5, 5] == [pending.one()["status"] for pending in held]


def test_the_result_of_a_wait_has_all_fields_of_the_ros_type(fast, wait):
    assert fast.do(WAIT, wait(7)) == {
        "status": 4,
        "result": {"total_elapsed_time": {"sec": 7, "nanosec": 0}, "error_code": 0, "error_msg": ""},
    }


def test_a_result_is_forgotten_after_its_time(serve, wait):
    """Its id is still refused, with how the goal ended."""
    tester = serve(real_time_factor=0, result_timeout=0.05)
    tester.send(WAIT, wait(1), A)

    answers = iter(lambda: tester.result(WAIT, A)["status"], 0)

    assert {4} >= set(answers)
    assert [] == tester.status(WAIT)
    assert "duplicate_goal_id" == tester.send(WAIT, wait(1), A)["reason"]
