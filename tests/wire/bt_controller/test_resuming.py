"""A restarted controller that resumes its goals in a real simulation."""

from __future__ import annotations

import pytest
from py_trees.common import Status

from bt_controller.behaviours.robot_actions import NavToPoseActionClient, pose_goal
from hmrsim.protocol.goal import GoalStatus
from hmrsim_zenoh.client.client import Client
from tests.patience import PATIENCE
from tests.served_world import served_world

NEAR, FAR = pose_goal(1.0, 0.0), pose_goal(5.0, 0.0)


@pytest.fixture
def life():
    """Return the function that restarts a controller: a leaf with some goals, and their tickets."""
    with served_world(clock="lockstep") as options, Client(options) as client:

        def begin(*goals):
            leaf = NavToPoseActionClient("Go", iter(goals).__next__)
            leaf.setup(client=client, robot="wall_e", resume="me/patrol/wall_e")
            leaf.tick_once()
            tickets = [leaf._handle]
            for _ in goals[1:]:
                tickets[-1].wait_accepted(5.0)
                leaf.initialise()
                tickets.append(leaf._handle)
            return leaf, tickets

        yield begin


def end(leaf):
    """Return the leaf's status when its goals have ended."""
    while leaf.status is Status.RUNNING:
        leaf._handle._wait(lambda: leaf._handle.done, 5.0)
        leaf.tick_once()
    return leaf.status


def test_a_resumed_leaf_follows_the_goal_that_replaced_its_own(life):
    first, (replaced, last) = life(FAR, NEAR)
    end(first)
    second, (found,) = life(FAR)

    assert (Status.SUCCESS, GoalStatus.ABORTED) == (end(second), replaced.status)
    assert (replaced.goal_id, last.goal_id) == (found.goal_id, second._handle.goal_id)
    assert GoalStatus.SUCCEEDED is second._handle.found


def test_a_changed_goal_is_sent_after_a_restart(life):
    first, _ = life(FAR)
    end(first)
    second, (sent,) = life(NEAR)

    assert (Status.SUCCESS, False) == (end(second), sent.adopted)


def test_a_resumed_goal_can_be_canceled_by_another_client(life):
    _, (sent,) = life(FAR)
    sent.wait_accepted(5.0)
    second, (found,) = life(FAR)
    found.wait_accepted(5.0)
    sent.cancel()

    assert (Status.FAILURE, GoalStatus.CANCELED) == (end(second), found.status)
    assert found is second._handle


def test_a_goal_that_was_dropped_for_that_of_another_leaf_is_sent_again(life):
    """A guard may charge the robot before the restarted tree reaches the leaf of the dropped goal."""
    first, (dropped,) = life(FAR)
    dropped.wait_accepted(5.0)
    first._client.send_goal(NEAR).result(PATIENCE)
    second, (found,) = life(FAR)

    assert (Status.SUCCESS, GoalStatus.ABORTED) == (end(second), found.status)
    assert (dropped.goal_id, True) == (found.goal_id, found.found.terminal)
    assert GoalStatus.SUCCEEDED is second._handle.status
