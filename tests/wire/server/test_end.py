"""The end of a simulation: every goal gets a terminal status, and every pending request an answer."""

from __future__ import annotations

import threading
from dataclasses import replace

import pytest

from hmrsim.actions import registry
from tests.patience import PATIENCE
from tests.wire.server.conftest import Heard

A, B = "a" * 32, "b" * 32
WAIT = "wall_e/wait"


def _raise(*_arguments):
    raise ZeroDivisionError("one of ours")


def _process_raises(robot, _goal, _report):
    yield from robot.hold(1.0)
    _raise()


def _feedback_raises(robot, _goal, report):
    yield from robot.hold(1.0)
    report.sample(_raise)
    yield from robot.hold(1000.0)


def _no_result(robot, _goal, _report):
    yield from robot.hold(1.0)


@pytest.fixture
def broken(serve, monkeypatch):
    """Serve the small world with another `wait` action; return a client."""

    def make(process, **settings):
        actions = {**registry(), "wait": replace(registry()["wait"], process=process)}
        monkeypatch.setattr("hmrsim.simulation.simulator.installed_actions", lambda: actions)
        return serve(**{"real_time_factor": 10.0, "strict": True} | settings)

    return make


def test_goals_that_run_are_aborted_at_the_end(live, serve, wait):
    heard = live.hear(f"{WAIT}/_action/status")
    live.send(WAIT, wait(1000), A)
    held = [live.begin(f"{WAIT}/_action/get_result", {"goal_id": A}) for _ in range(2)]
    live.status(WAIT)  # answered after the requests before it were taken

    serve.hosts[0].stop()

    answers = [pending.one() for pending in held]
    assert [(6, 740, "the simulator was stopped")] * 2 == [
        (answer["status"], answer["result"]["error_code"], answer["result"]["error_msg"]) for answer in answers
    ]
    heard.wait_for_status(A, 6)


@pytest.mark.parametrize("factor", [0, 1.0])
def test_the_end_leaves_no_thread(serve, go, factor):
    before = set(threading.enumerate())
    tester = serve(real_time_factor=factor)
    tester.hear("**")
    for robot in ("wall_e", "cart"):
        assert tester.send(f"{robot}/navigate_to_pose", go(9, 2))["accepted"]
    tester.begin("wall_e/navigate_to_pose/_action/get_result", {"goal_id": A})

    serve.hosts[0].stop()

    tester.close()
    for thread in set(threading.enumerate()) - before:
        thread.join(PATIENCE)
    assert before >= set(threading.enumerate())


def test_a_host_can_be_stopped_twice_and_before_its_start(serve):
    host = serve.host()

    host.stop()
    host.stop()

    assert host.error is None


def test_a_request_after_the_end_gets_no_reply(live, serve, wait):
    serve.hosts[0]._inbox.close()
    serve.hosts[0].wait(PATIENCE)

    assert [] == live.ask(f"{WAIT}/_action/send_goal", {"goal": wait(1)})


def test_requests_that_wait_at_the_end_get_one_reply_each(serve, monkeypatch, wait):
    entered, leave = threading.Event(), threading.Event()

    def stall(*_arguments):
        entered.set()
        assert leave.wait(PATIENCE)
        yield from ()

    actions = {**registry(), "wait": replace(registry()["wait"], process=stall)}
    monkeypatch.setattr("hmrsim.simulation.simulator.installed_actions", lambda: actions)
    tester = serve(real_time_factor=0)
    tester.send(WAIT, wait(1), A)
    assert entered.wait(PATIENCE)
    late = [
        tester.begin(f"{WAIT}/_action/send_goal", {"goal_id": B, "goal": wait(1)}),
        tester.begin(f"{WAIT}/_action/get_result", {"goal_id": A}),
        tester.begin(f"{WAIT}/_action/status"),
        tester.begin(f"{WAIT}/_action/cancel_goal", {}),
        tester.begin(f"{WAIT}/_action/execute", {"goal": wait(1)}),
    ]
    assert [] == list(tester.session.get("nobody/there"))  # comes back when those before it are with the server
    serve.hosts[0]._inbox.close()
    leave.set()

    goal, result, status, cancel, executed = [pending.one() for pending in late]

    for each in (goal, executed):
        assert (False, "not_ready", "the simulation has ended") == tuple(each[key] for key in _WHY)
    assert result["status"] in (4, 6)
    assert 1 == len(status["status_list"])
    assert [] == cancel["goals_canceling"]


@pytest.mark.parametrize("process", [_process_raises, _no_result])
def test_a_bug_in_an_action_aborts_its_goal_and_no_other(broken, serve, wait, go, process):
    """The simulator continues, and a subscriber of events is informed."""
    tester = broken(process, strict=False)
    events = tester.hear("_world/events")
    tester.hear(f"{WAIT}/_action/feedback")
    tester.send("eve/navigate_to_pose", go(1, 2), B)
    tester.send(WAIT, wait(1000), A)
    held = [tester.begin(f"{name}/_action/get_result", {"goal_id": goal_id}) for name, goal_id in _BOTH.items()]

    broken_one, other = [pending.one() for pending in held]

    assert (6, "bug in wait: ") == (broken_one["status"], broken_one["result"]["error_msg"][:13])
    assert 4 == other["status"]
    assert events.wait(lambda bodies: any(body["kind"] == "internal_error" for body in bodies))
    assert not serve.hosts[0].wait(0.0)


@pytest.mark.parametrize("process", [_process_raises, _feedback_raises, _no_result])
def test_a_bug_in_an_action_ends_a_strict_run_with_every_goal_aborted(broken, serve, wait, go, process):
    """The host raises the error."""
    tester = broken(process)
    heard = tester.hear("**")
    tester.send("eve/navigate_to_pose", go(1, 2), B)
    tester.send(WAIT, wait(1000), A)
    held = [tester.begin(f"{name}/_action/get_result", {"goal_id": goal_id}) for name, goal_id in _BOTH.items()]

    answers = [pending.one() for pending in held]

    assert [6, 6] == [answer["status"] for answer in answers]
    assert all(answer["result"]["error_msg"] for answer in answers)
    host = serve.hosts[0]
    assert host.wait(PATIENCE)
    assert isinstance(host.error, (ZeroDivisionError, TypeError))
    assert heard.items


_WHY = ("accepted", "reason", "error_msg")
_BOTH = {WAIT: A, "eve/navigate_to_pose": B}


def test_the_tokens_of_a_crashed_simulation_disappear(broken, serve, wait):
    """Requests are not left hanging, although the server is not closed yet."""
    tester = broken(_process_raises)
    heard = Heard()
    tester.send(WAIT, wait(1000), A)

    assert serve.hosts[0].wait(PATIENCE)

    assert [] == list(tester.session.liveliness().get("hmrsim/**"))
    assert [] == tester.ask(f"{WAIT}/_action/send_goal", {"goal": {}})
    assert not heard.items
