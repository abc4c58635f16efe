"""An errand: goals of one robot, one after another, until one fails."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

from hmrsim.actions import registry
from hmrsim.protocol.goal import GoalStatus
from hmrsim_zenoh.errors import ClientClosed, SimulatorGone

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim_zenoh.client.client import Client
    from hmrsim_zenoh.client.goal_handle import GoalHandle

Step: TypeAlias = tuple[str, Mapping[str, Any]]
"""The name of an action, and a goal in plain values."""


def send(client: Client, robot: str, steps: Sequence[Step], then: Callable[[bool], None]) -> None:
    """Send the first goal of an errand, and the others as time goes on.

    Args:
        client: It has time go on.
        robot: Who is to do it.
        steps: One at least.
        then: Called at the end with whether all goals have succeeded, not before time has gone on; never where the
            run ends before.
    """
    _Errand(client, robot, steps, then).go_on()


class _Errand:
    """An errand that is under way; the handles of its goals hold it."""

    def __init__(self, client: Client, robot: str, steps: Sequence[Step], then: Callable[[bool], None]) -> None:
        self._client = client
        self._robot = robot
        self._left = iter(steps)
        self._then = then

    def go_on(self) -> None:
        """Send the next goal, or tell that there is none."""
        step = next(self._left, None)
        if step is None:
            self._then(True)
            return
        action = self._client.action_client(self._robot, registry()[step[0]])
        action.send_goal(step[1], read_result=False, on_change=self._look)

    def _look(self, goal: GoalHandle[Any, Any]) -> None:
        if not goal.done:
            return
        if goal.status is GoalStatus.SUCCEEDED:
            self.go_on()
        elif not isinstance(goal.error, ClientClosed | SimulatorGone):
            self._then(False)


def go(point: Point) -> Step:
    """Return the goal to drive to a point."""
    return "navigate_to_pose", {"pose": {"pose": {"position": {"x": point[0], "y": point[1]}}}}


def pick_up(item: str) -> Step:
    """Return the goal to pick an item up."""
    return "pickup", {"target_name": item}


def put_down(item: str) -> Step:
    """Return the goal to put an item down where the robot is."""
    return "place", {"attached_object_name": item}


def dock(name: str) -> Step:
    """Return the goal to drive into a dock."""
    return "dock_robot", {"dock_id": name}
