"""Results and commands with a timeout in simulated seconds."""

from __future__ import annotations

import pytest

from hmrsim.actions import registry
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.nav2_msgs import Wait
from hmrsim.protocol.goal import GoalStatus
from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.client.commander import Commander
from hmrsim_zenoh.errors import GoalTimeout
from tests.patience import PATIENCE
from tests.served_world import served_world

WAIT = registry()["wait"]
CLOCKS = ({"clock": "lockstep"}, {"real_time_factor": 50.0})


def waiting(seconds):
    return Wait.Goal(time=Duration.from_seconds(seconds))


@pytest.fixture(params=CLOCKS, ids=["lockstep", "realtime"])
def client(request):
    """Return a client of a simulator with this clock."""
    with served_world(**request.param) as options, Client(options, name="nurse") as client:
        yield client


def test_a_result_within_the_timeout_is_returned(client):
    goal = client.action_client("wall_e", WAIT).send_goal(waiting(20))

    assert goal.result(PATIENCE, sim_timeout=30.0).total_elapsed_time == Duration(sec=20)


def test_the_goal_continues_after_a_timeout_and_can_be_awaited_again(client):
    goal = client.action_client("wall_e", WAIT).send_goal(waiting(60))
    begin = client.now
    with pytest.raises(GoalTimeout, match=r"no result of goal .* after 300 s or 15 simulated s; it goes on"):
        goal.result(PATIENCE, sim_timeout=15.0)

    assert 15.0 <= client.now - begin < 40.0
    assert goal.result(PATIENCE, sim_timeout=100.0).total_elapsed_time == Duration(sec=60)


def test_a_commander_cancels_the_goal_at_its_timeout(client):
    with pytest.raises(GoalTimeout, match="after 15 simulated s"):
        Commander(client, "wall_e", sim_timeout=15.0).wait(600)

    goal = client.action_client("wall_e", WAIT).send_goal(waiting(1))
    goal.result(PATIENCE)
    assert goal.status is GoalStatus.SUCCEEDED


def test_a_timeout_continues_when_lockstep_ends():
    with served_world(clock="lockstep") as options, Client(options, name="nurse") as client:
        goal = client.action_client("wall_e", WAIT).send_goal(waiting(600))
        goal.wait_accepted(PATIENCE)

        payload = b'{"clock":"realtime","real_time_factor":50}'
        client.ask("hmrsim/_world/time/set", payload, lambda _answer: None, timeout=5.0)
        with pytest.raises(GoalTimeout, match="after 15 simulated s"):
            goal.result(sim_timeout=15.0)
        assert client.now >= 15.0
