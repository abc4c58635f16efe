"""Following a goal that was sent before a restart, in real time and in lockstep."""

from __future__ import annotations

import pytest

from hmrsim.actions.wait import ACTION
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.nav2_msgs import Wait
from hmrsim.protocol.goal import GoalStatus
from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.errors import GoalRejectedError, ResultExpired
from tests.patience import PATIENCE
from tests.served_world import served_world

GOAL_ID = "00000000000000000000000000000abc"
CLOCKS = {"realtime": {"real_time_factor": 10.0}, "lockstep": {"clock": "lockstep"}}

pytestmark = pytest.mark.parametrize("clock", CLOCKS)


def wait(seconds):
    return Wait.Goal(time=Duration.from_seconds(seconds))


def send(client, seconds=1.0, goal_id=GOAL_ID, robot="wall_e", *, adopt=True):
    return client.action_client(robot, ACTION).send_goal(wait(seconds), goal_id=goal_id, adopt=adopt)


def test_an_unknown_goal_is_sent(clock):
    with served_world(**CLOCKS[clock]) as options, Client(options) as client:
        goal = send(client)
        goal.result(PATIENCE)

    assert (False, None, GoalStatus.SUCCEEDED) == (goal.adopted, goal.found, goal.status)


def test_a_running_goal_is_followed_to_its_result(clock):
    """Another client may have sent it."""
    with served_world(**CLOCKS[clock]) as options:
        with Client(options, name="first") as client:
            send(client, 30.0).wait_accepted(5.0)
        with Client(options, name="second") as client:
            goal = send(client, 30.0)
            result = goal.result(PATIENCE)

    assert (True, GoalStatus.EXECUTING, GoalStatus.SUCCEEDED) == (goal.adopted, goal.found, goal.status)
    assert 30.0 == result.total_elapsed_time.to_seconds()


@pytest.mark.parametrize("status", [GoalStatus.SUCCEEDED, GoalStatus.CANCELED])
def test_a_goal_that_has_ended_has_its_result_at_once(clock, status):
    with served_world(**CLOCKS[clock]) as options:
        with Client(options, name="first") as client:
            first = send(client, 30.0)
            first.wait_accepted(5.0)
            if status is GoalStatus.CANCELED:
                first.cancel()
            result = first.result(PATIENCE)
        with Client(options, name="second") as client:
            goal = send(client, 30.0)
            again = goal.result(PATIENCE)

    assert (True, status, status, result) == (goal.adopted, goal.found, goal.status, again)


def test_a_goal_whose_result_has_expired_says_how_it_ended(clock):
    """Its result is unknown, and the goal is not executed again."""
    with served_world(keep_results=1, **CLOCKS[clock]) as options, Client(options) as client:
        send(client).result(PATIENCE)
        send(client, goal_id="f" * 32).result(PATIENCE)
        goal = send(client)
        with pytest.raises(ResultExpired, match=f"goal {GOAL_ID} is SUCCEEDED, but its result is not kept any longer"):
            goal.result(PATIENCE)

    assert (True, GoalStatus.SUCCEEDED) == (goal.adopted, goal.status)


def test_without_adopt_the_id_of_an_existing_goal_is_refused(clock):
    with served_world(**CLOCKS[clock]) as options, Client(options) as client:
        send(client).result(PATIENCE)
        with pytest.raises(GoalRejectedError, match=r"duplicate_goal_id: goal .* was sent before and is SUCCEEDED"):
            send(client, adopt=False).result(PATIENCE)
