"""Faults that delay news of goals."""

from __future__ import annotations

import math

import pytest

from hmrsim.protocol.commands import Advance, CancelGoal, GetResult, Read
from hmrsim.protocol.goal import GoalStatus
from hmrsim.protocol.outputs import StatusChanged
from hmrsim.protocol.time import Join
from hmrsim.protocol.topics import Topic
from tests.simulation import SMALL_WORLD, A, B, in_lockstep, simulate, wait

ACCEPTED, EXECUTING, SUCCEEDED = 1, 2, 4


def late(delay=5.0, **keys):
    """Return a fault that delays the news of a robot."""
    return {"type": "result_late", "robot": "wall_e", "delay": delay, **keys}


def faulty(*faults, **settings):
    return simulate({**SMALL_WORLD, "faults": [*faults]}, **settings)


def rest(seconds, goal_id=A, robot="wall_e"):
    """Return the command that makes a robot wait, and answers with the result under the goal's id."""
    return wait(seconds, goal_id, robot, f"sent {goal_id}")._replace(result_to=goal_id)


def answered(log, reply_to=A):
    return [time for time, event in log.events if getattr(event, "reply_to", None) == reply_to]


def told(log, robot="wall_e"):
    return [
        (time, int(event.goals[-1].status))
        for time, event in log.events
        if isinstance(event, StatusChanged) and event.robot == robot
    ]


def test_statuses_and_result_arrive_late_but_not_the_acceptance():
    log = faulty(late())((1.0, rest(2)))

    assert [1.0] == answered(log, f"sent {A}")
    assert ((3.0, "SUCCEEDED"), [8.0]) == (log.changes(A)[-1], answered(log))
    assert GoalStatus.SUCCEEDED == log.answer(A).status
    assert [(6.0, ACCEPTED), (6.0, EXECUTING), (8.0, SUCCEEDED)] == told(log)


def test_a_request_for_the_status_gets_the_published_one():
    run = faulty(late())
    log = run((1.0, rest(2)), *((at, Read(Topic.STATUS, "wall_e", "wait", at)) for at in (4.0, 7.0, 9.0)))

    assert [[], [EXECUTING], [SUCCEEDED]] == [
        [int(goal.status) for goal in log.answer(at).goals] for at in (4.0, 7.0, 9.0)
    ]


def test_a_late_request_for_the_result_waits_until_it_arrives():
    log = faulty(late())((1.0, rest(2)), (4.0, GetResult("wall_e", "wait", A, "asked")))

    assert [8.0] == answered(log, "asked")


def test_news_of_other_robots_are_not_delayed():
    log = faulty(late())((1.0, rest(2, robot="eve")))

    assert ([3.0], 3.0) == (answered(log), told(log, "eve")[-1][0])


def test_a_cancel_is_not_delayed():
    log = faulty(late())((1.0, rest(9)), (2.0, CancelGoal("wall_e", "wait", A, reply_to="canceled")))

    assert ([2.0], [7.0]) == (answered(log, "canceled"), answered(log))


def test_all_news_arrive_when_the_fault_ends():
    log = faulty(late(until=4.0))((1.0, rest(2)), (5.0, rest(1, B)))

    assert ([4.0], [6.0]) == (answered(log), answered(log, B))
    assert [(4.0, ACCEPTED), (4.0, EXECUTING), (4.0, SUCCEEDED)] == told(log)[:3]


LOST = {"type": "messages_lost", "robot": "wall_e"}


@pytest.mark.parametrize(
    ("faults", "end"),
    [
        ([late(), late(3.0)], 11.0),
        ([late(), {**LOST, "at": 4.0, "until": 20.0}], 20.0),
        ([late(20.0), {**LOST, "at": 2.0, "until": 4.0}], 23.0),
    ],
    ids=["another delay", "a longer loss", "a shorter loss"],
)
def test_delays_add_up_but_not_with_a_lost_connection(faults, end):
    assert [end] == answered(faulty(*faults)((1.0, rest(2))))


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
def test_news_arrive_at_the_end_of_the_simulation(ends):
    run = faulty(late(100.0))
    run((1.0, rest(2)), until=4.0)
    before = answered(run.log)
    ends(run)

    assert ([], 1) == (before, len(answered(run.log)))


def test_a_script_gets_results_at_once():
    robots = {"wall_e": {"type": "nurse", "at": "home", "script": ["Go shelf", "Go home"]}}
    run = simulate({**SMALL_WORLD, "robots": robots, "remap": {}, "faults": [late()]})
    run()

    assert 16.0 == run.simulator.scripts.all["wall_e"].ended


def test_a_participant_in_lockstep_gets_the_result_late():
    run, lockstep = in_lockstep({**SMALL_WORLD, "faults": [late()]})
    lockstep.join(Join("nurse", "joined"), 0.0)
    goal = rest(2)._replace(reply_to=None, result_to=None)
    lockstep.advance(Advance("nurse", 0, math.inf, frozenset({"result"}), frozenset(), (goal,), "granted"), 0.0)
    lockstep.begin()
    while lockstep.proceed(16, 0.0):
        pass
    granted = run.log.answer("granted")

    assert (7.0, [("result", A)]) == (granted.now, [(kind, event.goal_id) for kind, _, event in granted.events])
