"""A blocking interface for sequential scripts, modeled on nav2_simple_commander.

::

    with Client() as client:
        mocha = Commander(client, "mocha")
        mocha.navigate_to("counter")
        mocha.pickup("coffee")
"""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING, Any, Concatenate, ParamSpec, TypeVar

from hmrsim.errors import HmrsimError
from hmrsim.interfaces.message import Message
from hmrsim_zenoh.client import verbs
from hmrsim_zenoh.client.battery import BATTERY_PERIOD, battery_of, charged_or_not_charging, is_charged

if TYPE_CHECKING:
    from collections.abc import Callable

    from hmrsim.geometry import Pose
    from hmrsim.interfaces.nav2_msgs import NavigateToPose
    from hmrsim.interfaces.sensor_msgs import BatteryState
    from hmrsim_zenoh.client.action_client import ActionClient
    from hmrsim_zenoh.client.client import Client
    from hmrsim_zenoh.client.places import NamedPlaces
    from hmrsim_zenoh.client.verbs import Request

P = ParamSpec("P")
R = TypeVar("R", bound=Message)

_CANCEL_PATIENCE = 2.0


def _blocking(verb: Callable[Concatenate[NamedPlaces, P], Request[R]]) -> Callable[Concatenate[Commander, P], R]:
    """Return the method that does what a verb requests, and waits for the result."""

    def method(self: Commander, /, *args: P.args, **kwargs: P.kwargs) -> R:
        return self._do(verbs.requested(verb, self._places, *args, **kwargs))

    verbs.present_as(verb, method)
    return method


class Commander:
    """Sends goals to one robot and waits for each result. Ctrl-C cancels the active goal.

    A target is the name of a waypoint, place or dock, ``(x, y)`` or ``(x, y, yaw)`` in the world's unit of length and
    radians, or a `PoseStamped`. Every method returns the action's result, or raises

    - `GoalFailed` when the goal was aborted or canceled,
    - `GoalRejectedError` when the robot rejected it,
    - `SimulatorNotFound`, `SimulatorGone`, `Unreachable`, `RequestError`, `GoalTimeout` when there is no usable answer;
      the lookup of a place is sent again once if its answer is lost,
    - `ValueError` when there is no place of that name or a value is invalid, and `TypeError` for any other target.
    """

    def __init__(
        self, client: Client, robot: str, *, timeout: float | None = None, sim_timeout: float | None = None
    ) -> None:
        """Create a commander for a robot.

        Args:
            client: The connection to its simulator.
            robot: Its name.
            timeout: Wall seconds for each goal, which is then canceled; None for no limit.
            sim_timeout: The same in simulated seconds.
        """
        self.robot = robot
        self._client = client
        self._timeout = timeout
        self._sim_timeout = sim_timeout
        self._places = client.places
        self._actions: dict[str, ActionClient[Any, Any, Any]] = {}

    def go_to_pose(self, x: float, y: float, yaw: float = 0.0) -> NavigateToPose.Result:
        """Drive to a point of the map; *yaw* in radians."""
        return self.navigate_to((x, y, yaw))

    navigate_to = _blocking(verbs.navigate_to)
    navigate_through = _blocking(verbs.navigate_through)
    follow_waypoints = _blocking(verbs.follow_waypoints)
    compute_path_to = _blocking(verbs.compute_path_to)
    compute_path_through = _blocking(verbs.compute_path_through)
    compute_route = _blocking(verbs.compute_route)
    track_route = _blocking(verbs.track_route)
    follow_path = _blocking(verbs.follow_path)
    smooth_path = _blocking(verbs.smooth_path)
    spin = _blocking(verbs.spin)
    back_up = _blocking(verbs.back_up)
    drive_on_heading = _blocking(verbs.drive_on_heading)
    dock = _blocking(verbs.dock)
    undock = _blocking(verbs.undock)
    pickup = _blocking(verbs.pickup)
    place = _blocking(verbs.place)
    wait = _blocking(verbs.wait)
    do = _blocking(verbs.do)

    def pose(self) -> Pose:
        """Return where the robot is, as it reports it in ``odom``.

        Returns:
            x and y in the world's unit of length, yaw in radians, in the frame ``map``. It can be a target.

        Raises:
            RequestError, Unreachable: There is no such robot.
        """
        return self._client.pose_of(self.robot)

    def battery(self) -> BatteryState:
        """Return the state of the battery; its *percentage* is from 0 to 1, as in ROS.

        Raises:
            RequestError, Unreachable: There is no such robot, or it has no battery.
        """
        return battery_of(self._client, self.robot)

    def wait_until_charged(self, percentage: float = 0.9) -> BatteryState:
        """Wait, in simulated time, until the battery has a share of its capacity, and return its state.

        Raises:
            ValueError: The share is not from 0 to 1.
            NotCharging: It has less, and is not charged, or no longer.
            RequestError, Unreachable: There is no such robot, or it has no battery.
        """
        conditions = charged_or_not_charging(self.robot, percentage)
        while not is_charged(self.robot, state := self.battery(), percentage):
            lockstep = self._client.lockstep
            if lockstep is None:
                self._client.sleep(BATTERY_PERIOD)
            else:
                lockstep.wait_for(*conditions)
        return state

    def _do(self, request: Request[R]) -> R:
        action = request.definition
        client = self._actions.get(action.name)
        if client is None:
            client = self._actions[action.name] = self._client.action_client(self.robot, action)
        handle = client.execute(request.goal, on_feedback=request.on_feedback)
        try:
            handle.result(self._timeout, sim_timeout=self._sim_timeout)
        except BaseException:
            handle.cancel()
            # No robot keeps driving after the script ends.
            with suppress(HmrsimError):
                handle.result(_CANCEL_PATIENCE)
            raise
        return request.result_of(self.robot, handle)
