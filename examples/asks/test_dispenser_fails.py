"""A dispenser fails, and the task continues at another one.

Asked in https://github.com/open-rmf/rmf_demos/issues/330, where a task waits forever for a dispenser that has failed.
"""

from hmrsim.testing import simulation
from hmrsim_zenoh import Commander, GoalFailed

JAMMED = {"type": "item_lost", "item": "coffee", "at": 3}


def fetch(robot: Commander, items: list[str]) -> str:
    """Take the first available item and return its name."""
    robot.navigate_to("counter")
    for item in items:
        try:
            robot.pickup(item)
        except GoalFailed as failure:
            print(failure)
        else:
            return item
    return ""


def test_the_task_continues_at_the_other_dispenser() -> None:
    """There is no coffee, so the robot takes the cake."""
    with simulation("cafe", changes={"faults.+": JAMMED}) as run:
        mocha = run.commander("mocha")

        assert fetch(mocha, ["coffee", "cake"]) == "cake"

        mocha.navigate_to("table_2")
        assert [goal.status.name for goal in run.goals("mocha", action="pickup")] == ["ABORTED", "SUCCEEDED"]
