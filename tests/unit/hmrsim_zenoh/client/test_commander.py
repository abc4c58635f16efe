"""The blocking interface to robots."""

from __future__ import annotations

import asyncio

import pytest

from hmrsim.actions import registry
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.nav2_msgs import Wait
from hmrsim.testing import simulation
from hmrsim_zenoh import AsyncClient, GoalFailed, NotCharging, RequestError


@pytest.mark.parametrize("action", ["wait", registry()["wait"]])
@pytest.mark.parametrize("goal", [{"time": {"sec": 3}}, Wait.Goal.model_validate({"time": {"sec": 3}})])
def test_a_goal_of_any_action(action, goal):
    """The action may be given by name, and the goal as a message or as plain values."""
    with simulation("cafe") as run:
        result = run.commander("mocha").do(action, goal)

        assert isinstance(result, Wait.Result)
        assert 3.0 == run.now


def test_a_pose_by_name():
    with simulation("cafe") as run:
        run.commander("mocha").do("navigate_to_pose", {"pose": "counter"})

        assert ["counter"] == run.visited("mocha")
        with pytest.raises(ValueError, match=r"goal: pose: no place 'conter'; did you mean 'counter'"):
            run.commander("mocha").do("navigate_to_pose", {"pose": "conter"})


def test_a_goal_of_any_action_with_asyncio():
    told = []

    async def play(client):
        async with AsyncClient(client) as robots:
            await robots.robot("mocha").do("wait", {"time": {"sec": 3}}, on_feedback=told.append)

    with simulation("cafe") as run:
        asyncio.run(play(run.client))

        assert 3.0 == run.now
    assert all(isinstance(one, Wait.Feedback) for one in told)
    assert told


@pytest.mark.parametrize(
    ("action", "error"),
    [
        ("wipe", "no action 'wipe' is installed; there are "),
        ("wiat", r"no action 'wiat' is installed; did you mean 'wait'\?"),
    ],
)
def test_an_action_that_is_not_installed(action, error):
    """The call raises an error before anything is sent."""
    with simulation("cafe") as run, pytest.raises(ValueError, match=error):
        run.commander("mocha").do(action, {})


def test_a_goal_with_other_fields():
    """The simulator's error names the field."""
    with simulation("cafe") as run, pytest.raises(RequestError, match=r"goal\.tiem"):
        run.commander("mocha").do("wait", {"tiem": {}})


def test_a_goal_that_fails():
    with simulation("cafe") as run, pytest.raises(GoalFailed, match="mocha: pickup ended ABORTED: no item 'tea'"):
        run.commander("mocha").do("pickup", {"target_name": "tea"})


def test_a_charge_is_waited_for():
    """Simulated time stops at that charge."""
    with simulation("cafe", changes={"robots.mocha.components.battery.initial_charge": 1000}) as run:
        mocha = run.commander("mocha")
        assert 0.333 == round(mocha.battery().percentage, 3)
        mocha.dock("charger_1")
        state = mocha.wait_until_charged(0.8)

        assert 0.8 == round(state.percentage, 6)
        assert 20 < run.now < 30


def test_a_charge_that_does_not_come():
    with simulation("cafe") as run:
        chai = run.commander("chai")
        chai.wait(6)
        with pytest.raises(NotCharging, match="'chai' does not charge"):
            chai.wait_until_charged(1.0)
        with pytest.raises(ValueError, match=r"-0.1 is not a share of a capacity; expected a number from 0 to 1"):
            chai.wait_until_charged(-0.1)
        with pytest.raises(RequestError, match="no robot 'wally'; there are: mocha, latte, chai"):
            run.commander("wally").battery()


def test_feedback_of_a_goal_that_has_ended_wakes_nobody():
    """Time no longer stops for feedback once the goal of a listener has ended."""
    with simulation("cafe") as run:
        client = run.client.action_client("mocha", registry()["wait"])
        heard = []
        client.send_goal(Wait.Goal(time=Duration(sec=3)), on_feedback=heard.append).result()
        before = len(heard)
        client.send_goal(Wait.Goal(time=Duration(sec=3))).result()

        assert before > 0
        assert frozenset({"result"}) == run.client.lockstep._kinds()
        assert before == len(heard)
