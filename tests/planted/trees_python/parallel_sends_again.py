"""A Parallel that does not keep successes lets the faster robot repeat its errand."""

from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy
from py_trees.composites import Parallel, Selector, Sequence
from steps import GoToItem, Holds, patient

from bt_controller.behaviours.robot_actions import GoTo, Pickup, Place


def mission(robots: list[str], *, bug: bool = False) -> Behaviour:
    """Return the tree of two robots, each of which brings something to its ward and comes home."""
    soup, linen = _errand(robots[0], "soup", "ward_1", "home_1"), _errand(robots[1], "linen", "ward_2", "home_2")
    policy = ParallelPolicy.SuccessOnAll(synchronise=not bug)  # the bug: what has succeeded is ticked again
    return Parallel("Both", policy, [soup, linen])


def _errand(robot: str, item: str, ward: str, home: str) -> Behaviour:
    fetch = Sequence(f"Fetch {item}", memory=True, children=[GoToItem(item, robot), Pickup(item, robot=robot)])
    have = Selector(f"Have {item}", memory=True, children=[Holds(item, robot), fetch])
    steps = [have, GoTo(ward, robot=robot), Place(item, robot=robot), GoTo(home, robot=robot)]
    return patient(Sequence(f"Errand of {robot}", memory=True, children=steps))
