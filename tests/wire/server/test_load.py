"""Many requests, dying clients and a busy simulator lose nothing and stall nothing."""

from __future__ import annotations

import json

import pytest

A = "a" * 32
MANY = {"robots": {f"r{number}": {"at": [number, 0]} for number in range(100)}}
TERMINAL = {4, 5, 6}


def send_all(tester, names, goal):
    """Send a goal to each name without waiting; return (name, id, replies) of each."""
    ids = [f"{number:032x}" for number in range(1, len(names) + 1)]
    pending = [
        tester.begin(f"{name}/_action/send_goal", {"goal_id": goal_id, "goal": goal})
        for name, goal_id in zip(names, ids, strict=True)
    ]
    return [(name, goal_id, replies.all()) for name, goal_id, replies in zip(names, ids, pending, strict=True)]


@pytest.mark.parametrize("factor", [0, 100.0])
def test_three_hundred_goals_for_one_robot_each_end_once(serve, wait, factor):
    tester = serve(real_time_factor=factor)
    events = tester.hear("_world/events")

    sent = send_all(tester, ["wall_e/wait"] * 300, wait(1))

    assert [[True]] * 300 == [[reply.body["accepted"] for reply in replies] for _, _, replies in sent]
    verdicts = [tester.result(name, goal_id)["status"] for name, goal_id, _ in sent]
    assert set(verdicts) <= {4, 6}
    assert 4 == verdicts[-1]
    ends = [body["goal_id"] for body in _ended(events, 300)]
    assert sorted(goal_id for _, goal_id, _ in sent) == sorted(ends)
    assert 1 == tester.one("_world/info")["contract"]


@pytest.mark.parametrize("factor", [0, 100.0])
def test_three_hundred_goals_for_a_hundred_robots_each_end_once(serve, go, factor):
    tester = serve(MANY, real_time_factor=factor)
    names = [f"r{number % 100}/navigate_to_pose" for number in range(300)]

    sent = send_all(tester, names, go(50, 20))

    assert [[True]] * 300 == [[reply.body["accepted"] for reply in replies] for _, _, replies in sent]
    held = [tester.begin(f"{name}/_action/get_result", {"goal_id": goal_id}) for name, goal_id, _ in sent]
    verdicts = [pending.one()["status"] for pending in held]
    assert set(verdicts) <= {4, 6}
    assert [4] * 100 == verdicts[200:]


def _ended(events, count):
    """Return the first *count* ends of goals."""

    def ends(bodies):
        return [body for body in bodies if body["kind"] == "status" and body["status"] in TERMINAL]

    return ends(events.wait(lambda bodies: len(ends(bodies)) >= count))


@pytest.mark.parametrize("factor", [0.01, 1.0, 1e6])
def test_requests_are_answered_at_any_speed(serve, wait, factor):
    """This includes a factor that the machine can't reach, with samples all the time."""
    tester = serve(real_time_factor=factor)
    heard = tester.hear("**")
    tester.send("wall_e/wait", wait(100_000_000), A)
    heard.wait(lambda bodies: len(bodies) >= 2)

    tester.cancel("wall_e/wait", A)

    assert 5 == tester.result("wall_e/wait", A)["status"]


def test_time_advances_during_endless_requests(serve, wait):
    tester = serve(real_time_factor=0)
    tester.send("wall_e/wait", wait(1000), A)
    held = tester.begin("wall_e/wait/_action/get_result", {"goal_id": A})
    others = [serve.tester(serve.hosts[0]) for _ in range(3)]

    pending = [other.begin("eve/odom") for _ in range(200) for other in others]

    assert 4 == held.one()["status"]
    assert 600 == len([replies.one() for replies in pending])


def test_a_blocked_subscriber_does_not_stop_the_simulation(serve, wait):
    import zenoh  # noqa: PLC0415

    tester = serve(real_time_factor=0)
    lazy = serve.tester(serve.hosts[0])
    unread = lazy.session.declare_subscriber("hmrsim/_world/clock", zenoh.handlers.RingChannel(1))

    tester.do("wall_e/wait", wait(1000))

    assert {"clock": {"sec": 1000, "nanosec": 0}} == tester.one("_world/clock")
    assert json.loads(unread.recv().payload.to_string())["clock"]["sec"] >= 0
