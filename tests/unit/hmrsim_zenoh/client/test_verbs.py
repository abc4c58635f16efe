"""The verbs of a robot, which `Commander` and `AsyncRobot` share."""

from __future__ import annotations

import asyncio
import inspect
import math

import pytest

from hmrsim.errors import HmrsimError
from hmrsim.geometry import Pose
from hmrsim.interfaces.nav2_msgs import NavigateToPose
from hmrsim.testing import simulation
from hmrsim_zenoh import AsyncClient, AsyncRobot, Commander
from hmrsim_zenoh.client import verbs
from hmrsim_zenoh.client.verbs import Request

VERBS = [
    name
    for name, function in inspect.getmembers(verbs, inspect.isfunction)
    if function.__module__ == verbs.__name__ and not name.startswith("_") and name not in ("requested", "present_as")
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


TARGET = r"expected the name of a place, finite numbers \(x, y\) or \(x, y, yaw\), or a PoseStamped, got "
SECONDS = "wait: seconds: expected a number that is at least 0, got "


@pytest.mark.parametrize(
    ("call", "error", "text"),
    [
        (lambda robot: robot.navigate_to(7), TypeError, f"target: {TARGET}7"),
        (lambda robot: robot.navigate_to({"x": 3, "y": 3}), TypeError, f"target: {TARGET}{{'x': 3, 'y': 3}}"),
        (lambda robot: robot.navigate_to((1,)), TypeError, rf"target: {TARGET}\(1,\)"),
        (lambda robot: robot.navigate_to((math.nan, 1)), TypeError, rf"target: {TARGET}\(nan, 1\)"),
        (lambda robot: robot.navigate_through(["hall", 7]), TypeError, rf"targets\[1\]: {TARGET}7"),
        (lambda robot: robot.follow_waypoints("hall"), TypeError, "targets: expected a list of targets, got 'hall'"),
        (lambda robot: robot.compute_route("hall", start=7), TypeError, f"start: {TARGET}7"),
        (
            lambda robot: robot.wait("five"),
            ValueError,
            f"{SECONDS}'five'",
        ),
        (lambda robot: robot.wait(-1), ValueError, f"{SECONDS}-1"),
        (
            lambda robot: robot.wait(math.nan),
            ValueError,
            f"{SECONDS}nan",
        ),
        (lambda robot: robot.pickup(5), ValueError, "pickup: target_name: input should be a valid string, got 5"),
        (lambda robot: robot.spin("left"), ValueError, "spin: target_yaw: input should be a valid number, got 'left'"),
    ],
)
def test_an_invalid_value_is_an_error_before_anything_is_sent(call, error, text):
    """It names the value, the parameter or field, and what is expected."""

    async def play(client):
        async with AsyncClient(client) as robots:
            await call(robots.robot("mocha"))

    with simulation("cafe") as run:
        with pytest.raises(error, match=f"^{text}$"):
            call(run.commander("mocha"))
        with pytest.raises(error, match=f"^{text}$"):
            asyncio.run(play(run.client))

        assert not run.goals()


@pytest.mark.parametrize("target", ["hall", (3, 4), [3.0, 4.0, 1], Pose(3, 4, 1)])
def test_a_target_may_be_a_name_or_numbers(target):
    with simulation("cafe") as run:
        assert run.commander("mocha").compute_path_to(target).path.poses


@pytest.mark.parametrize("call", [lambda robot: robot.wait(1), lambda robot: robot.pose()])
def test_an_unknown_robot(call):
    """The error has the name probably meant, whether the robot's actions or its topics are used."""
    with simulation("cafe") as run, pytest.raises(HmrsimError, match=r"no robot 'moca'; did you mean 'mocha'\?$"):
        call(run.commander("moca"))
