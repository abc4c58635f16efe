"""Accepted and rejected goals, and the answers of send_goal."""

from __future__ import annotations

import pytest

A, B = "a" * 32, "b" * 32
NAVIGATE = "wall_e/navigate_to_pose"
SEND = "wall_e/navigate_to_pose/_action/send_goal"


def test_an_accepted_goal_is_answered_with_its_id_and_stamp(fast, go):
    """A stamp of zero would mean unset, so at time zero it is one nanosecond."""
    (reply,) = fast.ask(SEND, {"goal_id": A, "goal": go(9, 2)})

    assert {"accepted": True, "goal_id": A, "stamp": {"sec": 0, "nanosec": 1}} == reply.body
    assert (True, "hmrsim/wall_e/navigate_to_pose/_action/send_goal") == (reply.ok, reply.key)


def test_what_is_sent_after_an_answer_is_accepted_later(live, wait):
    """Time passes between an answer and the next request, so no two stamps are equal."""
    stamps = [live.send("wall_e/wait", wait(1000))["stamp"] for _ in range(100)]

    times = [(stamp["sec"], stamp["nanosec"]) for stamp in stamps]
    assert sorted(set(times)) == times


def test_a_goal_without_id_gets_one(fast, go):
    answer = fast.send(NAVIGATE, go(5, 2))

    assert (32, set()) == (len(answer["goal_id"]), set(answer["goal_id"]) - set("0123456789abcdef"))
    assert 4 == fast.result(NAVIGATE, answer["goal_id"])["status"]


def test_an_id_may_have_hyphens_and_capitals(fast, go):
    """Both forms name the same goal, and the answer has neither."""
    answer = fast.send(NAVIGATE, go(5, 2), "AAAAAAAA-AAAA-AAAA-AAAA-AAAAAAAAAAAA")

    assert (True, A) == (answer["accepted"], answer["goal_id"])
    assert 4 == fast.result(NAVIGATE, "aaaaaaaa-AAAA-aaaa-aaaa-aaaaaaaaaaaa")["status"]


@pytest.mark.parametrize(
    ("name", "goal", "goal_id", "reason", "code", "text"),
    [
        (NAVIGATE, {}, "0" * 32, "invalid_goal_id", 1, "zero"),
        (NAVIGATE, {}, "not-a-uuid", "invalid_goal_id", 1, "'not-a-uuid' is not a UUID"),
        (NAVIGATE, {}, "a" * 31, "invalid_goal_id", 1, "not a UUID"),
        ("wall_e/pickup", {}, "0" * 32, "invalid_goal_id", 99999, "zero"),
        ("eve/place", {}, "?", "invalid_goal_id", 99999, "'?' is not a UUID"),
        ("nobody/wait", {}, A, "unknown_robot", 1, "no robot 'nobody'; there are: cart, eve, wall_e"),
        ("wall_e/fly", {"wings": 2}, A, "unknown_action", 1, "wall_e has no action 'fly'; it has: "),
        ("cart/pickup", {"target_name": "parcel"}, A, "unknown_action", 99999, "cart has no action 'pickup'"),
        (NAVIGATE, {"pose": {"header": {"frame_id": "odom"}}}, A, "invalid_goal", 1, "unknown frame_id 'odom'"),
    ],
)
def test_an_unexecutable_goal_is_rejected_with_reason_code_and_text(shared, name, goal, goal_id, reason, code, text):
    (reply,) = shared.ask(f"{name}/_action/send_goal", {"goal_id": goal_id, "goal": goal})

    assert (True, False, reason, code) == (
        reply.ok,
        reply.body["accepted"],
        reply.body["reason"],
        reply.body["error_code"],
    )
    assert text in reply.body["error_msg"]
    assert goal_id == reply.body["goal_id"]


def test_the_id_of_a_goal_that_runs_is_refused(live, wait):
    first = live.send("wall_e/wait", wait(1000), A)

    again = live.send("wall_e/wait", wait(1000), A)

    assert (False, "duplicate_goal_id", 2, first["stamp"]) == (
        again["accepted"],
        again["reason"],
        again["status"],
        again["stamp"],
    )
    assert [(A, 2)] == live.status("wall_e/wait")


@pytest.fixture
def crowded(serve, wait, monkeypatch):
    """Return a client of a busy simulator in which no request may wait."""
    from hmrsim_zenoh.server.inbox import ChannelInbox  # noqa: PLC0415

    monkeypatch.setitem(ChannelInbox.__init__.__kwdefaults__, "max_waiting", 0)
    tester = serve(real_time_factor=1.0)
    tester.send("wall_e/wait", wait(1000), A)
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
