"""Missions of the page's reader."""

from py_trees.composites import Sequence
from py_trees.decorators import Retry

from bt_controller.behaviours.robot_actions import GoTo, Pickup, Place


def deliver(robots, code=0):
    """Bring the medicine to a ward."""
    robot = robots[0]
    steps = [
        GoTo("pharmacy", robot=robot),
        Pickup("medicine", robot=robot),
        GoTo("ward_a", robot=robot),
        Place("medicine", robot=robot),
    ]
    return Sequence(f"Deliver by {code}", memory=True, children=steps)


def rounds(robots):
    """Go there and back, and try again at once after a failure."""
    robot = robots[0]
    children = [GoTo("pharmacy", robot=robot), GoTo("ward_a", robot=robot)]
    return Retry("Try again", Sequence("Rounds", memory=True, children=children), 6)
