"""A fleet adapter is tried without the robot that it is for.

Asked in https://github.com/open-rmf/fleet_adapter_ecobot/issues/5. The adapter below is written against an interface of
its own, as for a vendor's robot; the simulated robot stands behind it.
"""

from typing import Protocol

from hmrsim.testing import simulation
from hmrsim_zenoh import Commander, GoalFailed


class RobotApi(Protocol):
    """What adapters ask of a vendor's robot."""

    def navigate(self, place: str) -> bool:
        """Drive to a place; return whether it is there."""


class SimulatedRobot:
    """The interface, with a simulated robot behind it."""

    def __init__(self, commander: Commander) -> None:
        self._commander = commander

    def navigate(self, place: str) -> bool:
        """Drive to a place; return whether it is there."""
        try:
            self._commander.navigate_to(place)
        except GoalFailed:
            return False
        return True


def clean(robot: RobotApi, rooms: list[str]) -> list[str]:
    """Be the adapter: visit rooms, try each twice, and return those that were missed."""
    return [room for room in rooms if not (robot.navigate(room) or robot.navigate(room))]


def test_the_adapter_tries_twice() -> None:
    """A drive that fails once is no missed room."""
    once = {"type": "goals_aborted", "robot": "chai", "action": "navigate_to_pose", "count": 1, "at": 5, "duration": 60}
    with simulation("cafe", changes={"faults.+": once}) as run:
        assert clean(SimulatedRobot(run.commander("chai")), ["counter", "entrance", "table_1"]) == []
        assert len(run.goals("chai", status="ABORTED")) == 1
