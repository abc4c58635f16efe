"""Ids of goals that say their run, and requests that are withdrawn."""

from __future__ import annotations

import json

from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.nav2_msgs import Wait
from hmrsim.protocol.commands import GetResult, SendGoal, StopWaiting
from hmrsim.protocol.goal import GoalStatus, ResultResponse
from hmrsim.trace.replay import replay
from tests.simulation import simulate


def made_id(**settings):
    """Return the id of a goal that was sent without one, and the lines of the trace."""
    run = simulate(traced=True, **settings)
    run((0.0, SendGoal("wall_e", "wait", Wait.Goal(time=Duration(sec=1)), None, "reply")))
    return run.log.answer("reply").goal_id, run.lines()


def test_another_run_generates_other_ids():
    """A client of an earlier run must not cancel a goal of this one."""
    assert 3 == len({made_id(run_id=run_id)[0] for run_id in ("", "one", "two")})


def test_in_lockstep_each_run_generates_the_same_ids():
    """Traces of runs in lockstep are then equal."""
    ids = [made_id(run_id=run_id, clock="lockstep") for run_id in ("one", "two")]

    assert ids[0] == ids[1]
    assert made_id()[0] == ids[0][0]


def test_a_replay_generates_the_ids_of_its_run():
    goal_id, lines = made_id(run_id="one")

    assert any(goal_id in line for line in lines)
    assert replay(lines).difference is None


GOAL = "a" * 32
SEND = SendGoal("wall_e", "wait", Wait.Goal(time=Duration(sec=10)), GOAL)


def ask(reply_to):
    return GetResult("wall_e", "wait", GOAL, reply_to)


def test_a_withdrawn_request_is_not_answered():
    gone, there = "gone", "there"
    log = simulate()((0, SEND), (1, ask(gone)), (1, ask(there)), (2, StopWaiting("wall_e", "wait", GOAL, (gone,))))

    assert [] == log.answers(gone)
    assert 1 == len(log.answers(there))


def test_a_client_that_can_not_wait_is_answered_at_once():
    log = simulate()((0, SEND), (1, ask("there")), (2, StopWaiting("wall_e", "wait", GOAL, ("there",), tell=True)))

    assert [ResultResponse(GoalStatus.EXECUTING, Wait.Result())] == log.answers("there")


def test_withdrawing_an_answered_or_unknown_request_has_no_effect():
    log = simulate()(
        (0, SEND),
        (1, ask("there")),
        (11, StopWaiting("wall_e", "wait", GOAL, ("there",))),
        (12, StopWaiting("wall_e", "spin", GOAL, ("there",))),
    )

    assert 1 == len(log.answers("there"))


def test_a_withdrawal_is_not_traced():
    run = simulate(traced=True)
    run((0, SEND), (1, StopWaiting("wall_e", "wait", GOAL, ("there",))))

    written = [json.loads(line) for line in run.lines()]
    assert ["send_goal"] == [line["command"] for line in written if line["kind"] == "command"]
