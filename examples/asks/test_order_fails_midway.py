"""An order fails midway, and you see what was done, what was not, and where the load is.

Asked in https://github.com/VDA5050/VDA5050/issues/511: the effects of a failed order are not specified, and
implementations differ. Here each action of the order ends once, and the controller decides what follows.
"""

from dataclasses import dataclass, field

from hmrsim.testing import simulation
from hmrsim_zenoh import Commander, GoalFailed


@dataclass
class Order:
    """A sequence of actions with their progress."""

    waiting: list[tuple[str, str]]
    finished: list[tuple[str, str]] = field(default_factory=list)
    failed: tuple[str, str] | None = None

    def run(self, robot: Commander) -> None:
        """Execute the waiting actions until one fails."""
        while self.waiting:
            name, subject = self.waiting.pop(0)
            try:
                {"drive": robot.navigate_to, "pick": robot.pickup, "drop": robot.place}[name](subject)
            except GoalFailed:
                self.failed = name, subject
                return
            self.finished.append((name, subject))


def test_the_robot_does_not_start_the_actions_after_the_failure() -> None:
    """The load stays on the robot, and the order lists its waiting actions."""
    broken = {"type": "goals_aborted", "robot": "mocha", "action": "navigate_to_pose", "count": 1, "at": 8}
    with simulation("cafe", changes={"faults.+": broken}) as run:
        order = Order([("drive", "counter"), ("pick", "coffee"), ("drive", "table_1"), ("drop", "coffee")])
        order.run(run.commander("mocha"))

        assert order.failed == ("drive", "table_1")
        assert order.waiting == [("drop", "coffee")]
        assert run.carrier("coffee") == "mocha"
        assert all(goal.status.terminal for goal in run.goals())
