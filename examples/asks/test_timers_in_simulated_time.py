"""The timers of a tree run in simulated time.

Asked in https://github.com/splintered-reality/py_trees_ros/issues/147, where timers use the wall clock while the
simulation uses its own.
"""

import time

from py_trees.behaviour import Behaviour
from py_trees.composites import Sequence

from bt_controller import GoTo, Wait
from hmrsim.testing import simulation


def patrol(robot: str) -> Behaviour:
    """Stand for a quarter of an hour at each of two places."""
    steps = [GoTo("table_1"), Wait(900), GoTo("table_2"), Wait(900, name="Wait again")]
    return Sequence(f"{robot} patrols", memory=True, children=steps)


def test_half_an_hour_passes_in_less_than_a_minute() -> None:
    """The timers use the simulation's clock."""
    began = time.monotonic()
    with simulation("cafe", tree=patrol, robots=["mocha"]) as run:
        run.to_the_end()
        run.check_succeeded()

        assert 1800 < run.now < 1900
    assert time.monotonic() - began < 60
