"""The tree of the page's reader."""

from py_trees.composites import Sequence

from bt_controller.behaviours.robot_actions import Wait
from bt_controller.examples import hospital


def mission(robot, wait_at_doors=0):
    """Carry out the mission of the hospital, after a wait."""
    return Sequence("Careful", memory=True, children=[Wait(wait_at_doors), hospital.mission(robot)])
