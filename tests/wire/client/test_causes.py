"""Causes of goals that did not succeed, as clients receive them from a real simulator."""

from __future__ import annotations

import pytest

from hmrsim.actions import registry
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.nav2_msgs import Wait
from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.client.commander import Commander
from hmrsim_zenoh.errors import GoalFailed
from tests.patience import PATIENCE
from tests.served_world import served_world


@pytest.fixture(params=[{"clock": "lockstep"}, {"real_time_factor": 50.0}], ids=["lockstep", "realtime"])
def client(request):
    """Return a client of a simulator with this clock."""
    with served_world(**request.param) as options, Client(options, name="nurse") as client:
        yield client


@pytest.mark.parametrize("verb", ["send_goal", "execute"])
def test_a_preempted_goal_has_its_cause(client, verb):
    """Goals that succeeded or still run have none."""
    wait = client.action_client("wall_e", registry()["wait"])
    first = getattr(wait, verb)(Wait.Goal(time=Duration(sec=600)))
    first.wait_accepted(PATIENCE)
    assert first.cause == ""
    second = getattr(wait, verb)(Wait.Goal(time=Duration(sec=1)))
    for goal in (first, second):
        goal.result(PATIENCE)

    assert (first.cause, second.cause) == ("preempted", "")


def test_the_error_of_a_commander_has_the_cause(client):
    with pytest.raises(GoalFailed) as caught:
        Commander(client, "wall_e").go_to_pose(-1e6, 0.0)

    assert caught.value.cause == "no_route"
