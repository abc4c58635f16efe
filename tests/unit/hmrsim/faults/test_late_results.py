"""News of goals that reach clients late, while the robot and the world go on."""

from __future__ import annotations

import math

import pytest

from hmrsim.interfaces.nav2_msgs import Wait
from hmrsim.protocol.commands import Advance, CancelGoal, GetResult, Read, SendGoal
from hmrsim.protocol.goal import GoalStatus
from hmrsim.protocol.outputs import StatusChanged
from hmrsim.protocol.time import Join
from hmrsim.protocol.topics import Topic
from hmrsim.trace.replay import replay
from tests.simulation import SMALL_WORLD, in_lockstep, simulate

A, B = "a" * 32, "b" * 32
ACCEPTED, EXECUTING, SUCCEEDED = 1, 2, 4


def late(delay=5.0, **keys):
    """Return a fault by which a robot's news are late."""
    return {"type": "result_late", "robot": "wall_e", "delay": delay, **keys}


def faulty(*faults, **settings):
    """Return a simulation of the small world with faults."""
    return simulate({**SMALL_WORLD, "faults": [*faults]}, **settings)


def rest(seconds, goal_id=A, robot="wall_e"):
    """Return the command that lets a robot wait, whose result is awaited under the goal's id."""
    goal = Wait.Goal.model_validate({"time": {"sec": seconds}})
    return SendGoal(robot, "wait", goal, goal_id, f"sent {goal_id}", result_to=goal_id)


def answered(log, reply_to=A):
    """Return when something was answered."""
    return [time for time, event in log.events if getattr(event, "reply_to", None) == reply_to]


def told(log, robot="wall_e"):
    """Return which statuses were published when."""
    return [
        (time, int(event.goals[-1].status))
        for time, event in log.events
        if isinstance(event, StatusChanged) and event.robot == robot
    ]


def test_a_result_is_answered_late():
    """The goal has ended by then."""
    log = faulty(late())((1.0, rest(2)))

    assert ((3.0, "SUCCEEDED"), [8.0]) == (log.changes(A)[-1], answered(log))
    assert GoalStatus.SUCCEEDED == log.answer(A).status


def test_a_goal_is_accepted_at_once():
    """Requests are not late."""
    log = faulty(late())((1.0, rest(2)))

    assert [1.0] == answered(log, f"sent {A}")


def test_its_status_is_told_late():
    """In order."""
    log = faulty(late())((1.0, rest(2)))

    assert [(6.0, ACCEPTED), (6.0, EXECUTING), (8.0, SUCCEEDED)] == told(log)


def test_who_asks_for_the_status_is_told_what_was_told():
    """And not what has happened."""
    run = faulty(late())
    log = run((1.0, rest(2)), *((at, Read(Topic.STATUS, "wall_e", "wait", at)) for at in (4.0, 7.0, 9.0)))

    assert [[], [EXECUTING], [SUCCEEDED]] == [
        [int(goal.status) for goal in log.answer(at).goals] for at in (4.0, 7.0, 9.0)
    ]


def test_who_asks_for_a_result_waits_until_it_is_there():
    """Also after the goal has ended."""
    log = faulty(late())((1.0, rest(2)), (4.0, GetResult("wall_e", "wait", A, "asked")))

    assert [8.0] == answered(log, "asked")


def test_other_robots_are_in_time():
    """It is the news of one that are late."""
    log = faulty(late())((1.0, rest(2, robot="eve")))

    assert ([3.0], 3.0) == (answered(log), told(log, "eve")[-1][0])


def test_a_cancel_is_answered_at_once():
    """Its goal's end is told late."""
    log = faulty(late())((1.0, rest(9)), (2.0, CancelGoal("wall_e", "wait", A, reply_to="canceled")))

    assert ([2.0], [7.0]) == (answered(log, "canceled"), answered(log))


def test_all_news_arrive_when_the_fault_ends():
    """In order; what follows is in time."""
    log = faulty(late(until=4.0))((1.0, rest(2)), (5.0, rest(1, B)))

    assert ([4.0], [6.0]) == (answered(log), answered(log, B))
    assert [(4.0, ACCEPTED), (4.0, EXECUTING), (4.0, SUCCEEDED)] == told(log)[:3]


def test_two_delays_add_up():
    """While both last."""
    log = faulty(late(), late(3.0))((1.0, rest(2)))

    assert [11.0] == answered(log)


def test_a_result_does_not_arrive_while_the_connection_is_lost():
    """It comes when that is back."""
    log = faulty(late(), {"type": "messages_lost", "robot": "wall_e", "at": 4.0, "until": 20.0})((1.0, rest(2)))

    assert [20.0] == answered(log)


def test_a_connection_that_is_back_does_not_make_a_result_arrive():
    """It is under way still."""
    log = faulty(late(20.0), {"type": "messages_lost", "robot": "wall_e", "at": 2.0, "until": 4.0})((1.0, rest(2)))

    assert [23.0] == answered(log)


@pytest.mark.parametrize(
    "ends",
    [
        lambda run: run.simulator.stop(),
        lambda run: run.ask("reset_simulation"),
        lambda run: run.ask("delete_entity", {"entity": "wall_e"}),
        lambda run: run.ask("clear_fault"),
    ],
    ids=["the end of the run", "a reset", "the end of the robot", "a repair"],
)
def test_no_client_waits_for_ever(ends):
    """What is under way arrives when nothing would bring it any more."""
    run = faulty(late(100.0))
    run((1.0, rest(2)), until=4.0)
    before = answered(run.log)
    ends(run)

    assert ([], 1) == (before, len(answered(run.log)))


def test_a_script_knows_at_once():
    """It is the robot's own."""
    robots = {"wall_e": {"type": "nurse", "at": "home", "script": ["Go shelf", "Go home"]}}
    run = simulate({**SMALL_WORLD, "robots": robots, "remap": {}, "faults": [late()]})
    run()

    assert 16.0 == run.simulator.scripts.all["wall_e"].ended


def test_a_participant_in_lockstep_is_told_late():
    """Time goes on until then."""
    run, lockstep = in_lockstep({**SMALL_WORLD, "faults": [late()]})
    lockstep.join(Join("nurse", "joined"), 0.0)
    goal = rest(2)._replace(reply_to=None, result_to=None)
    lockstep.advance(Advance("nurse", 0, math.inf, frozenset({"result"}), frozenset(), (goal,), "granted"), 0.0)
    lockstep.begin()
    while lockstep.proceed(16, 0.0):
        pass
    granted = run.log.answer("granted")

    assert (7.0, [("result", A)]) == (granted.now, [(kind, event.goal_id) for kind, _, event in granted.events])


def test_a_replay_has_the_same_run():
    """Though no client listens to it."""
    run = faulty(late(at=1.0, duration=6.0), traced=True)
    run((0.0, rest(2)), (3.0, rest(2, B)), until=20.0)
    outcome = replay(run.lines())

    assert (True, None) == (outcome.complete, outcome.difference)
