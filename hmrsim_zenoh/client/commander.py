"""A blocking interface for sequential scripts, modelled on nav2_simple_commander.

::

    with Client() as client:
        wall_e = Commander(client, "wall_e")
        wall_e.go_to_pose(512, 215)
        wall_e.pickup("medicine")
"""

from __future__ import annotations

import math
from contextlib import suppress
from typing import TYPE_CHECKING, Any, TypeVar

from hmrsim.actions import error_of, registry
from hmrsim.errors import HmrsimError
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.geometry_msgs import Point, Pose, PoseStamped, Quaternion
from hmrsim.interfaces.message import Message
from hmrsim.interfaces.moveit_msgs import Pickup, Place
from hmrsim.interfaces.nav2_msgs import NavigateToPose, Wait
from hmrsim.protocol.goal import GoalStatus
from hmrsim_zenoh.errors import GoalFailed

if TYPE_CHECKING:
    from hmrsim_zenoh.client.action_client import ActionClient
    from hmrsim_zenoh.client.client import Client

R = TypeVar("R", bound=Message)

_CANCEL_PATIENCE = 2.0


class Commander:
    """Sends goals to one robot and waits for each result. Ctrl-C cancels the active goal.

    Every method returns the action's result, or raises

    - `GoalFailed` when the goal was aborted or canceled,
    - `GoalRejectedError` when the robot rejected it,
    - `SimulatorNotFound`, `SimulatorGone`, `RequestError`, `GoalTimeout` when there is no usable answer.
    """

    def __init__(
        self, client: Client, robot: str, *, timeout: float | None = None, sim_timeout: float | None = None
    ) -> None:
        """Command a robot.

        Args:
            client: The connection to its simulator.
            robot: Its name.
            timeout: Wall seconds for each goal, which is then canceled; None for no limit.
            sim_timeout: Likewise, simulated seconds.
        """
        self.robot = robot
        self._client = client
        self._timeout = timeout
        self._sim_timeout = sim_timeout
        self._actions: dict[str, ActionClient[Any, Any, Any]] = {}

    def go_to_pose(self, x: float, y: float, yaw: float = 0.0) -> NavigateToPose.Result:
        """Drive to a place of the map; *yaw* in radians."""
        turned = Quaternion(z=math.sin(yaw / 2), w=math.cos(yaw / 2))
        pose = Pose(position=Point(x=float(x), y=float(y)), orientation=turned)
        goal = NavigateToPose.Goal(pose=PoseStamped(pose=pose))
        return self._do("navigate_to_pose", goal, NavigateToPose.Result)

    def pickup(self, name: str) -> Pickup.Result:
        """Pick up an item that is in reach."""
        return self._do("pickup", Pickup.Goal(target_name=name), Pickup.Result)

    def place(self, name: str) -> Place.Result:
        """Put down a held item."""
        return self._do("place", Place.Goal(attached_object_name=name), Place.Result)

    def wait(self, seconds: float) -> Wait.Result:
        """Stand still for *seconds* of simulated time."""
        return self._do("wait", Wait.Goal(time=Duration.from_seconds(seconds)), Wait.Result)

    def _do(self, name: str, goal: Message, result_type: type[R]) -> R:
        if name not in self._actions:
            self._actions[name] = self._client.action_client(self.robot, registry()[name])
        handle = self._actions[name].execute(goal)
        try:
            result = handle.result(self._timeout, sim_timeout=self._sim_timeout)
        except BaseException:
            handle.cancel()
            # No robot keeps driving after the script ends.
            with suppress(HmrsimError):
                handle.result(_CANCEL_PATIENCE)
            raise
        if not isinstance(result, result_type):
            raise TypeError(f"{name} gave {result!r}")
        if handle.status is not GoalStatus.SUCCEEDED:
            why = _why(result)
            text = f"{self.robot}: {name} ended {handle.status.name}: {why}"
            raise GoalFailed(text, handle.status, result, handle.cause)
        return result


def _why(result: Message) -> str:
    """Return a result's error message: Nav2's and MoveIt's results have it in different fields."""
    code, text = getattr(result, "error_code", None), error_of(result)
    number = getattr(code, "val", code)
    return f"{text} ({number})" if text else f"error code {number}"
