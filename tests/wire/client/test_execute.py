"""A client's goals that are sent with one query each."""

from __future__ import annotations

import math
import time

import pytest

from hmrsim.actions import registry
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.nav2_msgs import Wait
from hmrsim.protocol.goal import GoalStatus
from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.client.worker import Worker
from hmrsim_zenoh.errors import GoalRejectedError, RequestError, SimulatorGone
from hmrsim_zenoh.wire.keys import Verb
from tests.patience import PATIENCE
from tests.served_world import served_world

GOAL = Wait.Goal(time=Duration(sec=2))
SUCCEEDED, ABORTED = 4, 6


@pytest.fixture
def wait_client(client):
    return client.action_client("wall_e", registry()["wait"])


@pytest.mark.parametrize("clock", ["realtime", "lockstep"])
def test_a_goal_is_executed_by_a_simulator(clock, watched):
    """Changes, feedback, result and cancel are those of `send_goal`."""
    with served_world(clock=clock, real_time_factor=0) as options, Client(options) as client:
        wait = client.action_client("wall_e", registry()["wait"])
        seen = []
        goal = wait.execute(GOAL, on_feedback=seen.append, on_change=lambda goal: watched(goal.status))

        assert goal.result(PATIENCE).total_elapsed_time == Duration(sec=2)
        watched.wait(lambda statuses: statuses[-1:] == [GoalStatus.SUCCEEDED])
        assert seen or clock == "realtime"
        rejected = client.action_client("zoe", registry()["wait"]).execute(GOAL)
        with pytest.raises(GoalRejectedError, match="unknown_robot"):
            rejected.result(PATIENCE)


def test_acceptance_and_result_are_replies_to_one_query(simulator, wait_client):
    simulator.steps["execute"] = [simulator.both(simulator.accept, simulator.hold)]
    goal = wait_client.execute(GOAL)
    goal.wait_accepted(PATIENCE)
    assert (goal.status, goal.done) == (GoalStatus.ACCEPTED, False)

    simulator.release(simulator.end(SUCCEEDED, total_elapsed_time={"sec": 2}), verb=Verb.EXECUTE)
    assert goal.result(PATIENCE) == Wait.Result(total_elapsed_time=Duration(sec=2))
    ((name, body),) = simulator.requests
    assert (name, body["goal_id"]) == ("execute", goal.goal_id)


def test_a_robot_without_the_key_is_reached_by_send_goal(wait_client, simulator):
    simulator.steps["get_result"] = [simulator.end(SUCCEEDED)]

    assert wait_client.execute(GOAL).result(PATIENCE) == Wait.Result()
    assert ["execute", "send_goal", "get_result"] == [name for name, _ in simulator.requests]


def test_a_result_that_was_lost_after_the_acceptance_is_requested(wait_client, simulator):
    simulator.steps["execute"] = [simulator.accept]
    simulator.steps["get_result"] = [simulator.lose, simulator.end(ABORTED)]
    goal = wait_client.execute(GOAL)

    assert goal.result(PATIENCE) == Wait.Result()
    assert goal.status is GoalStatus.ABORTED


def test_a_goal_without_any_reply_is_sent_again(wait_client, simulator):
    """The second request finds the goal, and its result is requested."""
    simulator.steps["send_goal"] = [simulator.refuse("duplicate_goal_id", status=2)]
    simulator.steps["get_result"] = [simulator.end(SUCCEEDED)]

    assert wait_client.execute(GOAL).result(PATIENCE) == Wait.Result()


@pytest.mark.parametrize("text", ["so it is", '{"error": "so it is"}'])
def test_a_goal_that_gets_an_error_is_not_sent_again(wait_client, simulator, text):
    simulator.steps["execute"] = [simulator.say_error(text)]

    with pytest.raises(RequestError, match="so it is"):
        wait_client.execute(GOAL).result(PATIENCE)
    assert simulator.count(Verb.SEND_GOAL) == 0


def test_a_simulator_that_dies_fails_its_goals(wait_client, simulator):
    simulator.steps["execute"] = [simulator.both(simulator.accept, simulator.hold)]
    goal = wait_client.execute(GOAL)
    goal.wait_accepted(PATIENCE)
    simulator.close()

    with pytest.raises(SimulatorGone):
        goal.result(PATIENCE)


def test_a_cancel_is_sent_on_its_own_key_after_the_acceptance(wait_client, simulator):
    simulator.steps["execute"] = [simulator.both(simulator.accept, simulator.hold)]
    simulator.steps["cancel_goal"] = [simulator.canceling]
    goal = wait_client.execute(GOAL)
    goal.cancel()

    assert goal.goal_id == simulator.wait_for(Verb.CANCEL_GOAL)[0]["goal_info"]["goal_id"]


def test_rounded_calls_are_made_together(watched):
    """Between one and two delays; calls that are added meanwhile come in a later round."""
    worker = Worker("test")
    begin = time.monotonic()
    for number in range(3):
        worker.after(0.01, lambda number=number: watched((number, time.monotonic() - begin)), rounded=True)
    worker.after(0.01, lambda: worker.after(0.01, lambda: watched(("last", math.inf)), rounded=True), rounded=True)

    called = watched.wait(lambda items: len(items) == 4)
    assert [0, 1, 2, "last"] == [name for name, _ in called]
    assert all(after >= 0.01 for _, after in called)
    worker.close()
