"""The verbs of a robot, which `Commander` and `AsyncRobot` share."""

from __future__ import annotations

import inspect

import pytest

from hmrsim.errors import HmrsimError
from hmrsim.interfaces.nav2_msgs import NavigateToPose
from hmrsim.testing import simulation
from hmrsim_zenoh import AsyncRobot, Commander
from hmrsim_zenoh.client import verbs
from hmrsim_zenoh.client.verbs import Request

VERBS = [
    name
    for name, function in inspect.getmembers(verbs, inspect.isfunction)
    if function.__module__ == verbs.__name__ and not name.startswith("_")
]


@pytest.mark.parametrize("robot", [Commander, AsyncRobot])
def test_a_robot_has_every_verb(robot):
    """Each verb is a method with the same parameters and documentation."""
    assert VERBS
    for name in VERBS:
        verb, method = getattr(verbs, name), getattr(robot, name)
        (_places, *expected), (first, *parameters) = (
            inspect.signature(one).parameters.values() for one in (verb, method)
        )
        assert ("self", expected) == (first.name, parameters)
        result = inspect.signature(method).return_annotation
        assert f"Request[{result}]" == inspect.signature(verb).return_annotation
        assert inspect.iscoroutinefunction(method) == (robot is AsyncRobot)
        assert verb.__doc__ == method.__doc__


def test_a_verb_reports_feedback():
    """The callback receives the messages of the action."""
    feedback = []

    with simulation("cafe") as run:
        run.commander("mocha").navigate_to("counter", on_feedback=feedback.append)

    assert feedback
    assert all(isinstance(each, NavigateToPose.Feedback) for each in feedback)


def test_a_result_of_another_action_is_a_bug():
    with simulation("cafe") as run:
        handle = run.client.action_client("mocha", Request("wait", {}, object).definition).send_goal({})
        handle.result()

        with pytest.raises(TypeError, match="wait gave "):
            Request("wait", {}, NavigateToPose.Result).result_of("mocha", handle)


@pytest.mark.parametrize("call", [lambda robot: robot.wait(1), lambda robot: robot.pose()])
def test_an_unknown_robot(call):
    """The error has the name probably meant, whether the robot's actions or its topics are used."""
    with simulation("cafe") as run, pytest.raises(HmrsimError, match=r"no robot 'moca'; did you mean 'mocha'\?$"):
        call(run.commander("moca"))
