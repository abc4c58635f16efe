"""Coverage shows which nodes of a tree a test has ticked, and which ones it never has.

Asked in https://github.com/ros-navigation/navigation2/issues/2801 and
https://github.com/splintered-reality/py_trees/issues/230.
"""

from py_trees.behaviour import Behaviour
from py_trees.composites import Selector

from bt_controller import GoTo
from hmrsim.testing import simulation


def visit(robot: str) -> Behaviour:
    """Go to table 3, or to table 1 if that fails."""
    return Selector(f"{robot} visits", memory=True, children=[GoTo("table_3"), GoTo("table_1")])


def ticked(**options: object) -> dict[str, int]:
    """Return how often each node was ticked."""
    with simulation("cafe", tree=visit, robots=["mocha"], coverage=True, **options) as run:
        run.to_the_end()
        (tree,) = run.coverage.trees
        return {node.name: node.ticks for node in run.coverage.nodes(tree)}


def test_a_successful_run_does_not_tick_the_fallback() -> None:
    """The first node succeeds, so the second one is never ticked."""
    assert ticked()["Go to table_1"] == 0


def test_a_closed_corridor_ticks_the_fallback() -> None:
    """With a closed corridor both nodes are ticked."""
    closed = {"type": "lane_closed", "lane": ["corridor_west", "corridor_east"], "at": 0}

    assert all(ticked(changes={"faults.+": closed}).values())
