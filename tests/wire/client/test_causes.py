"""Why goals did not succeed, as clients are told by a real simulator."""

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
    """Return a client of a simulator whose time passes in this way."""
    with served_world(**request.param) as options, Client(options, name="nurse") as client:
        yield client


@pytest.mark.parametrize("verb", ["send_goal", "execute"])
def test_a_goal_that_is_preempted_says_so(client, verb):
    """One that succeeds has no cause, and none that goes on."""
    wait = client.action_client("wall_e", registry()["wait"])
    first = getattr(wait, verb)(Wait.Goal(time=Duration(sec=600)))
    first.wait_accepted(PATIENCE)
    assert first.cause == ""
    second = getattr(wait, verb)(Wait.Goal(time=Duration(sec=1)))
    for goal in (first, second):
        goal.result(PATIENCE)

    assert (first.cause, second.cause) == ("preempted", "")


def test_a_commander_raises_it(client):
    """With the error that says the rest."""
    with pytest.raises(GoalFailed) as caught:
        Commander(client, "wall_e").go_to_pose(-1e6, 0.0)

    assert caught.value.cause == "no_route"
