"""A fleet adapter is tested without its robot.

Asked in https://github.com/open-rmf/fleet_adapter_ecobot/issues/5. The adapter below uses its own
interface to a vendor's robot, and the test implements that interface with a simulated robot.
"""

from typing import Protocol

from hmrsim.testing import simulation
from hmrsim_zenoh import Commander, GoalFailed


class RobotApi(Protocol):
    """The interface of a vendor's robot."""

    def navigate(self, place: str) -> bool:
        """Drive to a place; return whether the robot arrived."""


class SimulatedRobot:
    """An implementation of the interface with a simulated robot."""

    def __init__(self, commander: Commander) -> None:
        self._commander = commander

    def navigate(self, place: str) -> bool:
        """Drive to a place; return whether the robot arrived."""
        try:
            self._commander.navigate_to(place)
        except GoalFailed:
            return False
        return True


def clean(robot: RobotApi, rooms: list[str]) -> list[str]:
    """Visit rooms, trying each one twice, and return those that the robot missed."""
    return [room for room in rooms if not (robot.navigate(room) or robot.navigate(room))]


def test_the_adapter_tries_twice() -> None:
    """A room is not missed if only the first attempt fails."""
    once = {"type": "goals_aborted", "robot": "chai", "action": "navigate_to_pose", "count": 1, "at": 5, "duration": 60}
    with simulation("cafe", changes={"faults.+": once}) as run:
        assert clean(SimulatedRobot(run.commander("chai")), ["counter", "entrance", "table_1"]) == []
        assert len(run.goals("chai", status="ABORTED")) == 1
