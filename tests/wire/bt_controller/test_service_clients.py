"""Leaves that call the world's services, in real time and in lockstep."""

from __future__ import annotations

import pytest
from py_trees.blackboard import Blackboard
from py_trees.common import Status
from py_trees.composites import Sequence

from bt_controller.behaviours import service_clients
from bt_controller.behaviours.service_clients import FromBlackboard, FromConstant
from bt_controller.behaviours.subscribers import CheckData
from bt_controller.loading.trees import Plan
from bt_controller.running.clocks import Mailbox, clock_for
from bt_controller.running.mission import Mission
from bt_controller.running.runner import Runner
from hmrsim.interfaces.hmrsim_msgs import InjectFault
from hmrsim.interfaces.simulation_interfaces import (
    GetNamedPoses,
    ResetSimulation,
    SetEntityState,
    SetSimulationState,
    StepSimulation,
)
from hmrsim_zenoh.client.client import Client
from tests.served_world import served_world

CLOCKS = {"realtime": {}, "lockstep": {"clock": "lockstep"}}


@pytest.fixture(params=CLOCKS)
def run(request):
    """Return the function that runs a tree of one leaf and returns its final status."""
    with served_world(**CLOCKS[request.param]) as options, Client(options) as client:

        def end(leaf):
            mailbox = Mailbox()
            mission = Mission("wall_e", Plan("test", lambda: leaf, takes_robot=False, confirmed=False))
            clock = clock_for(client, mailbox, feedback=False, grace=1.0)
            Runner(client, [mission], clock, mailbox, show=None).run()
            return leaf.status

        yield end


class Noted(FromConstant):
    """Keeps its answer where the test can read it."""

    def update(self):
        status = super().update()
        self.answer = Blackboard.get("answer") if Blackboard.exists("answer") else None
        return status


def test_the_response_is_written_to_the_blackboard(run):
    leaf = Noted("Places", GetNamedPoses, "get_named_poses", GetNamedPoses.Request(), key_response="answer")

    assert Status.SUCCESS == run(leaf)
    assert "shelf" in [pose.name for pose in leaf.answer.poses]


def test_a_request_without_success_fails_with_the_reason(run):
    leaf = FromConstant("Break", InjectFault, "inject_fault", InjectFault.Request(type="earthquake"))

    assert Status.FAILURE == run(leaf)
    assert "earthquake" in leaf.feedback_message


def test_an_unknown_service_fails_and_lists_the_known_ones(run):
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
def test_a_leaf_without_a_request_calls_no_service(client, request_, message):
    leaf = FromBlackboard("Places", GetNamedPoses, "get_named_poses", "request")
    leaf.setup(client=client)
    Blackboard.set("request", request_)
    leaf.tick_once()

    assert (Status.FAILURE, message) == (leaf.status, leaf.feedback_message)


@pytest.mark.parametrize("run", ["lockstep"], indirect=True)
def test_the_effect_of_a_service_is_visible_at_the_same_instant(run):
    state = {"pose": {"position": {"x": 3.0, "y": 2.0}}}
    request = SetEntityState.Request.model_validate({"entity": "wall_e", "state": state})
    steps = [
        CheckData("Here", "odom", "pose.pose.position.x", 1.0, fail_if_bad_comparison=True),
        FromConstant("Move", SetEntityState, "set_entity_state", request),
        CheckData("There", "odom", "pose.pose.position.x", 3.0, fail_if_bad_comparison=True),
    ]

    assert Status.SUCCESS == run(Sequence("Root", memory=True, children=steps))


@pytest.mark.parametrize("run", ["lockstep"], indirect=True)
def test_a_service_that_takes_simulated_time_fails_in_lockstep(run, monkeypatch):
    """Time is stopped while the tree waits for the response."""
    monkeypatch.setattr(service_clients, "_AT_ONCE", 2.0)
    pause = SetSimulationState.Request.model_validate({"state": {"state": 2}})
    step = FromConstant("Step", StepSimulation, "step_simulation", StepSimulation.Request(steps=10))
    steps = [FromConstant("Pause", SetSimulationState, "set_simulation_state", pause), step]

    assert Status.FAILURE == run(Sequence("Root", memory=True, children=steps))
    assert step.feedback_message.endswith("in lockstep time stands meanwhile, so it must not take any")
