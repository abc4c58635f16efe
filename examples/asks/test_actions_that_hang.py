"""An action that hangs blocks neither the tree nor its test.

Asked in https://github.com/BehaviorTree/BehaviorTree.CPP/issues/930, where a mocked action that does not return blocks
the whole tree.
"""

from py_trees.behaviour import Behaviour
from py_trees.composites import Selector
from py_trees.decorators import Timeout

from bt_controller import GoTo
from hmrsim.testing import simulation

SLOW = {"type": "slip", "robot": "mocha", "factor": 0.001, "at": 0}


def visit(robot: str) -> Behaviour:
    """Go to table 1 within a minute, or give up there."""
    return Selector(f"{robot} visits", memory=True, children=[Timeout("In a minute", GoTo("table_1"), 60.0)])


def test_a_timeout_ends_a_drive_that_takes_forever() -> None:
    """The goal is canceled after a minute of simulated time, which passes instantly."""
    with simulation("cafe", tree=visit, robots=["mocha"], changes={"faults.+": SLOW}) as run:
        outcome = run.to_the_end()

        assert not outcome.succeeded
        assert 59 < run.now < 62
        assert [goal.status.name for goal in run.goals("mocha")] == ["CANCELED"]
