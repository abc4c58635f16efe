"""Leaves for actions, under the names that py_trees_ros has, and shorter ones."""

from __future__ import annotations

import pytest
from py_trees.blackboard import Blackboard
from py_trees.common import Status

from bt_controller.behaviours.action_clients import FromBlackboard, FromConstant
from bt_controller.behaviours.robot_actions import Dock, GoTo, Pickup, Place, Undock, Wait
from bt_controller.core.robots import NotServed
from hmrsim.interfaces import moveit_msgs, nav2_msgs
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim_zenoh.client.places import pose_at

GOAL = nav2_msgs.Wait.Goal(time=Duration(sec=3))


class TestFromConstant:
    """The same goal each time."""

    def test_it_sends_its_goal(self, client, equip):
        equip(FromConstant("Wait", "wait", GOAL)).tick_once()

        assert [GOAL] == [goal.goal for goal in client.goals]

    def test_it_shows_feedback_by_the_given_function(self, client, equip):
        """The argument has py_trees_ros's name: generate_feedback_message."""
        leaf = equip(FromConstant("Wait", "wait", GOAL, lambda feedback: f"{feedback.time_left.sec} s to go"))
        leaf.tick_once()
        client.goals[0].accept()
        client.goals[0].feed(time_left=Duration(sec=2))
        leaf.tick_once()

        assert "feedback: 2 s to go" == leaf.feedback_message

    def test_a_goal_of_another_action_is_refused_when_the_tree_is_built(self):
        with pytest.raises(TypeError, match="'Wait': wait takes nav2_msgs/action/Wait_Goal, got Goal"):
            FromConstant("Wait", "wait", moveit_msgs.Pickup.Goal(target_name="cup"))


class TestFromBlackboard:
    """A goal that another behavior has put there."""

    def test_it_sends_what_is_there(self, client, equip):
        leaf = equip(FromBlackboard("Wait", "wait", "next"))
        Blackboard.set("next", GOAL)
        leaf.tick_once()

        assert [GOAL] == [goal.goal for goal in client.goals]

    def test_without_a_goal_it_fails(self, client, equip):
        leaf = equip(FromBlackboard("Wait", "wait", "next"))
        leaf.tick_once()

        assert (Status.FAILURE, "no goal to send", []) == (leaf.status, leaf.feedback_message, client.goals)


@pytest.mark.parametrize(
    ("leaf", "name", "goal"),
    [
        (lambda: Pickup("cup"), "Pick up cup", moveit_msgs.Pickup.Goal(target_name="cup")),
        (lambda: Place("cup"), "Place cup", moveit_msgs.Place.Goal(attached_object_name="cup")),
        (lambda: Wait(2.5), "Wait 2.5 s", nav2_msgs.Wait.Goal(time=Duration.from_seconds(2.5))),
        (lambda: Dock("kitchen"), "Dock at kitchen", nav2_msgs.DockRobot.Goal(dock_id="kitchen", max_staging_time=0.0)),
        (Undock, "Undock", nav2_msgs.UndockRobot.Goal()),
        (lambda: GoTo("kitchen"), "Go to kitchen", nav2_msgs.NavigateToPose.Goal(pose=pose_at(3.0, 4.0))),
        (
            lambda: GoTo((1.0, 2.0, 0.5)),
            "Go to (1, 2, 0.5)",
            nav2_msgs.NavigateToPose.Goal(pose=pose_at(1.0, 2.0, 0.5)),
        ),
    ],
)
def test_short_leaves_send_the_goal_that_they_are_named_after(client, equip, leaf, name, goal):
    made = equip(leaf())
    made.tick_once()

    assert (name, [goal]) == (made.name, [sent.goal for sent in client.goals])


def test_a_place_that_is_not_there_is_an_error_before_the_first_tick(equip):
    with pytest.raises(NotServed, match="'Go to kitchn': no place 'kitchn'; there are kitchen"):
        equip(GoTo("kitchn"))


def test_the_messages_of_moveit_are_not_made_with_the_tree(monkeypatch):
    """To build them takes longer than all the rest; a tree that never picks anything up does without."""
    for action in (moveit_msgs.Pickup, moveit_msgs.Place):
        monkeypatch.setattr(action, "Goal", None)

    assert ("Pick up cup", "Place cup") == (Pickup("cup").name, Place("cup").name)
