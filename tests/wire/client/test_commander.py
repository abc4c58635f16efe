"""The commander, whose calls send one goal each and return its result or raise an error."""

from __future__ import annotations

import math

import pytest

from hmrsim.protocol.goal import GoalStatus
from hmrsim_zenoh.client.commander import Commander
from hmrsim_zenoh.errors import GoalFailed, GoalRejectedError, GoalTimeout
from hmrsim_zenoh.wire.keys import Verb

SUCCEEDED, CANCELED, ABORTED = 4, 5, 6


@pytest.fixture
def wall_e(client):
    return Commander(client, "wall_e")


@pytest.fixture
def sent(simulator):
    """Let every goal succeed, and return the goals sent."""
    simulator.steps["get_result"] = [simulator.end(SUCCEEDED)]
    return lambda: simulator.wait_for(Verb.SEND_GOAL)[-1]["goal"]


def test_go_to_pose_sends_a_pose_with_a_quaternion(wall_e, sent):
    result = wall_e.go_to_pose(512, 215, yaw=math.pi)

    pose = sent()["pose"]["pose"]
    assert (pose["position"], result.error_code) == ({"x": 512.0, "y": 215.0, "z": 0.0}, 0)
    assert (pose["orientation"]["z"], pose["orientation"]["w"]) == (1.0, pytest.approx(0.0))


def test_pickup_sends_moveits_target_name(wall_e, sent):
    wall_e.pickup("medicine")

    assert sent()["target_name"] == "medicine"


def test_place_sends_moveits_attached_object_name(wall_e, sent):
    wall_e.place("medicine")

    assert sent()["attached_object_name"] == "medicine"


def test_wait_sends_a_duration(wall_e, sent):
    wall_e.wait(1.5)

    assert sent() == {"time": {"sec": 1, "nanosec": 500_000_000}}


def test_an_aborted_nav2_goal_fails_with_its_message(simulator, wall_e):
    """Nav2 has error_code and error_msg."""
    simulator.steps["get_result"] = [simulator.end(ABORTED, error_code=208, error_msg="no route")]

    with pytest.raises(GoalFailed, match=r"wall_e: navigate_to_pose ended ABORTED: no route \(208\)") as caught:
        wall_e.go_to_pose(1, 2)
    assert (caught.value.status, caught.value.result.error_code) == (GoalStatus.ABORTED, 208)


def test_an_aborted_moveit_goal_fails_with_its_message(simulator, wall_e):
    """MoveIt has error_code.val and error_code.message."""
    failed = {"val": -1, "message": "out of reach", "source": ""}
    simulator.steps["get_result"] = [simulator.end(ABORTED, error_code=failed)]

    with pytest.raises(GoalFailed, match=r"wall_e: pickup ended ABORTED: out of reach \(-1\)"):
        wall_e.pickup("medicine")


def test_a_goal_that_another_client_cancels_fails(simulator, wall_e):
    simulator.steps["get_result"] = [simulator.end(CANCELED)]

    with pytest.raises(GoalFailed, match="wall_e: wait ended CANCELED: error code 0"):
        wall_e.wait(1)


def test_a_rejected_goal_raises_the_rejection(simulator, wall_e):
    simulator.steps["send_goal"] = [simulator.refuse("not_ready")]

    with pytest.raises(GoalRejectedError, match="not_ready"):
        wall_e.wait(1)


def test_a_goal_that_times_out_is_canceled(simulator, client):
    """The robot must not continue when the script has given up."""

    def cancel(query, body):
        simulator.canceling(query, body)
        simulator.release(simulator.end(CANCELED), verb=Verb.GET_RESULT)

    simulator.steps["cancel_goal"] = [cancel]
    with pytest.raises(GoalTimeout, match=r"no result of goal .* after 0.05 s"):
        Commander(client, "wall_e", timeout=0.05).wait(60)

    assert simulator.count(Verb.CANCEL_GOAL) == 1
