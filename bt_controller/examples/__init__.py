"""Example trees to start from.

`bt-controller run bt_controller.examples:go_to_pose` runs the first; the demo runs `hospital`.
"""

from __future__ import annotations

import operator
from typing import TYPE_CHECKING

from py_trees.behaviours import CheckBlackboardVariableValue
from py_trees.blackboard import Blackboard
from py_trees.common import ComparisonExpression, Status
from py_trees.composites import Selector, Sequence

from bt_controller.behaviours.robot_actions import NavToPoseActionClient, pose_goal
from bt_controller.loading.trees import confirmed

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour


@confirmed
def go_to_pose() -> Behaviour:
    """Return the tree that drives a robot to (450, 330), unless it has arrived there already."""
    Blackboard.set("arrived", Status.RUNNING)
    arrived = ComparisonExpression(variable="arrived", value=Status.SUCCESS, operator=operator.eq)
    check = CheckBlackboardVariableValue("CheckArrived", arrived)
    go = NavToPoseActionClient("GoToPoseAction", pose_goal(450.0, 330.0), on_success={"arrived": Status.SUCCESS})
    fallback = Selector("GoToPoseFallback", memory=True, children=[check, go])
    return Sequence("GoToPoseSequence", memory=True, children=[fallback])
