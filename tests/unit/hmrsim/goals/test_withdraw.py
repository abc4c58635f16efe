"""Requests for results that clients withdraw."""

from __future__ import annotations

import json

from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.nav2_msgs import Wait
from hmrsim.protocol.commands import GetResult, SendGoal, StopWaiting
from hmrsim.protocol.goal import GoalStatus, ResultResponse
from tests.simulation import simulate

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
