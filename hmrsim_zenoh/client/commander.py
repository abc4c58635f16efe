"""A blocking interface for sequential scripts, modelled on nav2_simple_commander.

::

    with Client() as client:
        mocha = Commander(client, "mocha")
        mocha.navigate_to("counter")
        mocha.pickup("coffee")
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any, TypeVar

from hmrsim.errors import HmrsimError
from hmrsim.interfaces.message import Message
from hmrsim_zenoh.client.charge import BATTERY_PERIOD, Charge
from hmrsim_zenoh.client.ended_goals import checked
from hmrsim_zenoh.client.errands import Errand, Errands, Target

if TYPE_CHECKING:
    from hmrsim.actions import AnyAction
    from hmrsim.interfaces.moveit_msgs import Pickup, Place
    from hmrsim.interfaces.nav2_msgs import (
        BackUp,
        ComputeAndTrackRoute,
        ComputePathThroughPoses,
        ComputePathToPose,
        ComputeRoute,
        DockRobot,
        DriveOnHeading,
        FollowPath,
        FollowWaypoints,
        NavigateThroughPoses,
        NavigateToPose,
        SmoothPath,
        Spin,
        UndockRobot,
        Wait,
    )
    from hmrsim.interfaces.nav_msgs import Path
    from hmrsim.interfaces.sensor_msgs import BatteryState
    from hmrsim_zenoh.client.action_client import ActionClient
    from hmrsim_zenoh.client.client import Client

R = TypeVar("R", bound=Message)

_CANCEL_PATIENCE = 2.0


class Commander:
    """Sends goals to one robot and waits for each result. Ctrl-C cancels the active goal.

    A target is the name of a waypoint, place or dock, ``(x, y)`` or ``(x, y, yaw)`` in the world's unit of length and
    radians, or a `PoseStamped`. Every method returns the action's result, or raises

    - `GoalFailed` when the goal was aborted or canceled,
    - `GoalRejectedError` when the robot rejected it,
    - `SimulatorNotFound`, `SimulatorGone`, `Unreachable`, `RequestError`, `GoalTimeout` when there is no usable answer;
      the lookup of a place is sent again once if its answer is lost,
    - `ValueError` when there is no place of that name.
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
        self._errands = Errands(client.places)
        self._charge = Charge(client, robot)
        self._actions: dict[str, ActionClient[Any, Any, Any]] = {}

    def go_to_pose(self, x: float, y: float, yaw: float = 0.0) -> NavigateToPose.Result:
        """Drive to a point of the map; *yaw* in radians."""
        return self._do(self._errands.navigate_to((x, y, yaw)))

    def navigate_to(self, target: Target) -> NavigateToPose.Result:
        """Drive to a place."""
        return self._do(self._errands.navigate_to(target))

    def navigate_through(self, targets: Sequence[Target]) -> NavigateThroughPoses.Result:
        """Drive to the last of some places by way of the others."""
        return self._do(self._errands.navigate_through(targets))

    def follow_waypoints(self, targets: Sequence[Target], *, loops: int = 0) -> FollowWaypoints.Result:
        """Visit places one after the other, and again so many times; the result names those that were missed."""
        return self._do(self._errands.follow_waypoints(targets, loops=loops))

    def compute_path_to(self, target: Target, start: Target | None = None) -> ComputePathToPose.Result:
        """Plan a path to a place, from the robot or from *start*."""
        return self._do(self._errands.compute_path_to(target, start))

    def compute_path_through(
        self, targets: Sequence[Target], start: Target | None = None
    ) -> ComputePathThroughPoses.Result:
        """Plan a path through places, from the robot or from *start*."""
        return self._do(self._errands.compute_path_through(targets, start))

    def compute_route(self, target: Target, start: Target | None = None) -> ComputeRoute.Result:
        """Plan a route along lanes, from the robot or from *start*."""
        return self._do(self._errands.compute_route(target, start))

    def track_route(self, target: Target) -> ComputeAndTrackRoute.Result:
        """Plan a route along lanes, and wait until the robot has come to its end, whatever else drives it."""
        return self._do(self._errands.track_route(target))

    def follow_path(self, path: Path) -> FollowPath.Result:
        """Drive along a path, such as ``compute_path_to(…).path``."""
        return self._do(self._errands.follow_path(path))

    def smooth_path(self, path: Path) -> SmoothPath.Result:
        """Smooth a path."""
        return self._do(self._errands.smooth_path(path))

    def spin(self, yaw: float) -> Spin.Result:
        """Turn on the spot by *yaw* radians, to the left if it is greater than 0."""
        return self._do(self._errands.spin(yaw))

    def back_up(self, distance: float, speed: float) -> BackUp.Result:
        """Drive straight back."""
        return self._do(self._errands.back_up(distance, speed))

    def drive_on_heading(self, distance: float, speed: float) -> DriveOnHeading.Result:
        """Drive straight on."""
        return self._do(self._errands.drive_on_heading(distance, speed))

    def dock(self, dock: str, *, navigate: bool = True) -> DockRobot.Result:
        """Dock at a dock, after a drive to its staging pose if *navigate*."""
        return self._do(self._errands.dock(dock, navigate=navigate))

    def undock(self) -> UndockRobot.Result:
        """Leave the dock."""
        return self._do(self._errands.undock())

    def pickup(self, name: str) -> Pickup.Result:
        """Pick up an item that is in reach."""
        return self._do(self._errands.pickup(name))

    def place(self, name: str) -> Place.Result:
        """Put down a held item."""
        return self._do(self._errands.place(name))

    def wait(self, seconds: float) -> Wait.Result:
        """Stand still for *seconds* of simulated time."""
        return self._do(self._errands.wait(seconds))

    def do(self, action: AnyAction | str, goal: Message | Mapping[str, Any]) -> Any:
        """Send a goal of any action, such as one of a package: ``mocha.do("wipe", {"strokes": 4})``.

        Args:
            action: The action, or its name.
            goal: The goal, or its plain values; fields that are left out have their defaults, and a pose may be the
                name of a place.

        Raises:
            ValueError: No action of this name is installed here, or there is no such place.
            RequestError: The simulator does not serve it, or the goal has other fields.
        """
        return self._do(self._errands.any(action, goal))

    def battery(self) -> BatteryState:
        """Return the state of the battery; its *percentage* is from 0 to 1, as in ROS.

        Raises:
            RequestError, Unreachable: There is no such robot, or it has no battery.
        """
        return self._charge.now()

    def wait_until_charged(self, percentage: float = 0.9) -> BatteryState:
        """Wait, in simulated time, until the battery has a share of its capacity, and return its state.

        Raises:
            ValueError: The share is not from 0 to 1.
            NotCharging: It has less, and is not charged, or no longer.
            RequestError, Unreachable: There is no such robot, or it has no battery.
        """
        conditions = self._charge.until(percentage)
        while not self._charge.reached(state := self._charge.now(), percentage):
            lockstep = self._client.lockstep
            if lockstep is None:
                self._client.sleep(BATTERY_PERIOD)
            else:
                lockstep.wait_for(*conditions)
        return state

    def _do(self, errand: Errand[R]) -> R:
        name = errand.name
        if name not in self._actions:
            self._actions[name] = self._client.action_client(self.robot, errand.definition)
        handle = self._actions[name].execute(errand.goal)
        try:
            handle.result(self._timeout, sim_timeout=self._sim_timeout)
        except BaseException:
            handle.cancel()
            # No robot keeps driving after the script ends.
            with suppress(HmrsimError):
                handle.result(_CANCEL_PATIENCE)
            raise
        return checked(self.robot, errand, handle)
