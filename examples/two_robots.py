"""Two robots work together: one tree for both, in which each step names who does it.

Start ``hmrsim run examples/two_robots.yaml --clock lockstep`` first, then run
``bt-controller run examples.two_robots:hand_over --robot wall_e eve``.
"""

from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy
from py_trees.composites import Parallel, Sequence

from bt_controller import GoTo, Pickup, Place


def hand_over(robots: list[str]) -> Behaviour:
    """Return the tree in which the first robot brings the medicine to the hatch, and the second one takes it on."""
    first, second = robots
    fetch = Sequence(
        "Fetch",
        memory=True,
        children=[GoTo("store", robot=first), Pickup("medicine", robot=first), GoTo("west", robot=first)],
    )
    meet = Parallel("Meet", ParallelPolicy.SuccessOnAll(), children=[fetch, GoTo("east", robot=second)])
    take = [Place("medicine", robot=first), Pickup("medicine", robot=second)]
    bring = [GoTo("ward", robot=second), Place("medicine", robot=second)]
    return Sequence("Hand over", memory=True, children=[meet, *take, *bring])
