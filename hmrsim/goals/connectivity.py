"""Robots that clients can reach."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simpy import Event

from hmrsim.errors import GoalRejected

if TYPE_CHECKING:
    from hmrsim.protocol.commands import CancelGoal, ChangeState, GetResult, SendGoal


class CutOff(set[str]):
    """The unreachable robots: requests are rejected, and results are withheld. Their scripts continue."""

    def reach(self, command: SendGoal | CancelGoal | GetResult | ChangeState) -> bool:
        """Return whether a request reaches its robot; requests of the robot's own script always do."""
        return command.robot not in self or isinstance(command.reply_to, Event)

    def check(self, command: SendGoal) -> None:
        """Check that a goal reaches its robot.

        Raises:
            GoalRejected: It does not.
        """
        if not self.reach(command):
            raise GoalRejected("not_ready", no_connection(command.robot))


def no_connection(robot: str) -> str:
    """Return why a robot can't be reached."""
    return f"no connection to {robot}; it is lost for a while"
