"""Leaves that ask the world's services, against a real simulator in both kinds of time."""

from __future__ import annotations

import pytest
from py_trees.blackboard import Blackboard
from py_trees.common import Status

from bt_controller.behaviours.service_clients import FromBlackboard, FromConstant
from bt_controller.running.clocks import clock_for
from bt_controller.running.mailbox import Mailbox
from bt_controller.running.mission import Mission
from bt_controller.running.runner import Runner
from bt_controller.trees import Plan
from hmrsim.interfaces.hmrsim_msgs import InjectFault
from hmrsim.interfaces.simulation_interfaces import GetNamedPoses, ResetSimulation
from hmrsim_zenoh.client import Client
from tests.hosted import hosted

CLOCKS = {"realtime": {}, "lockstep": {"clock": "lockstep"}}


@pytest.fixture(params=CLOCKS)
def run(request):
    """Return the function that runs a tree of one leaf: its status at the end."""
    with hosted(**CLOCKS[request.param]) as options, Client(options) as client:

        def end(leaf):
            mailbox = Mailbox()
            mission = Mission("wall_e", Plan("test", lambda: leaf, takes_robot=False, confirmed=False))
            clock = clock_for(client, mailbox, feedback=False, grace=1.0)
            Runner(client, [mission], clock, mailbox, show=None).run()
            return leaf.status

        yield end


class Noted(FromConstant):
    """Remembers its answer where the test can see it."""

    def update(self):
        """Take it from the blackboard."""
        status = super().update()
        self.answer = Blackboard.get("answer") if Blackboard.exists("answer") else None
        return status


def test_an_answer_goes_to_the_blackboard(run):
    """As the message that it is."""
    leaf = Noted("Places", GetNamedPoses, "get_named_poses", GetNamedPoses.Request(), key_response="answer")

    assert Status.SUCCESS == run(leaf)
    assert "shelf" in [pose.name for pose in leaf.answer.poses]


def test_a_request_of_which_nothing_came_fails_and_says_why(run):
    """Though there was an answer."""
    leaf = FromConstant("Break", InjectFault, "inject_fault", InjectFault.Request(type="earthquake"))

    assert Status.FAILURE == run(leaf)
    assert "earthquake" in leaf.feedback_message


def test_a_service_that_there_is_not_fails_and_says_which_there_are(run):
    """It is one line."""
    leaf = FromConstant("Reset", ResetSimulation, "reset_simulaton", ResetSimulation.Request())

    assert Status.FAILURE == run(leaf)
    assert "the world has no 'reset_simulaton' to get; there are: " in leaf.feedback_message


@pytest.mark.parametrize(
    ("request_", "message"),
    [
        (None, "no request to send"),
        ("open", "get_named_poses takes simulation_interfaces/srv/GetNamedPoses_Request, got 'open'"),
    ],
)
def test_without_a_request_nothing_is_asked(client, request_, message):
    """As with a goal."""
    leaf = FromBlackboard("Places", GetNamedPoses, "get_named_poses", "request")
    leaf.setup(client=client)
    Blackboard.set("request", request_)
    leaf.tick_once()

    assert (Status.FAILURE, message) == (leaf.status, leaf.feedback_message)
