"""Goals of all actions of a robot, from what people say: names of places, metres, radians, seconds.

Names are those of the actions, and of Nav2's ``BasicNavigator`` where it has one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from hmrsim.actions import registry
from hmrsim.diagnostics import instead, shown
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.geometry_msgs import Point, Pose, PoseStamped, Quaternion
from hmrsim.interfaces.message import Message
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
from hmrsim.interfaces.nav_msgs import Goals
from hmrsim_zenoh.client.goal_places import with_poses

if TYPE_CHECKING:
    from hmrsim.actions import AnyAction
    from hmrsim.interfaces.nav_msgs import Path
    from hmrsim_zenoh.client.places import NamedPlaces

R = TypeVar("R", bound=Message)

Target = str | tuple[float, float] | tuple[float, float, float] | PoseStamped
"""Where to: the name of a waypoint, place or dock; x, y and, if it matters, yaw, in the world's unit of length and
radians; or a pose."""


@dataclass(frozen=True)
class Errand(Generic[R]):
    """A goal of an action.

    Attributes:
        action: The action, or its name.
        goal: The goal, or its plain values.
        result: The type of its result.
    """

    action: AnyAction | str
    goal: Message | Mapping[str, Any]
    result: type[R]

    @property
    def name(self) -> str:
        """The action's name."""
        return self.action if isinstance(self.action, str) else self.action.name

    @property
    def definition(self) -> AnyAction:
        """The action.

        Raises:
            ValueError: None of this name is installed.
        """
        if not isinstance(self.action, str):
            return self.action
        known = registry()
        if self.action not in known:
            raise ValueError(f"no action {shown(self.action)} is installed{instead(self.action, known)}")
        return known[self.action]


class Errands:
    """Makes the goals of a robot, whose world has these places."""

    def __init__(self, places: NamedPlaces) -> None:
        self._places = places

    def pose(self, target: Target) -> PoseStamped:
        """Return where a target is.

        Raises:
            ValueError: There is no place of this name.
        """
        if isinstance(target, PoseStamped):
            return target
        return self._places.pose(target) if isinstance(target, str) else pose_at(*target)

    def navigate_to(self, target: Target) -> Errand[NavigateToPose.Result]:
        """Return a drive to a place."""
        return Errand("navigate_to_pose", NavigateToPose.Goal(pose=self.pose(target)), NavigateToPose.Result)

    def navigate_through(self, targets: Sequence[Target]) -> Errand[NavigateThroughPoses.Result]:
        """Return a drive to a place by way of others."""
        goal = NavigateThroughPoses.Goal(poses=self._goals(targets))
        return Errand("navigate_through_poses", goal, NavigateThroughPoses.Result)

    def follow_waypoints(self, targets: Sequence[Target], *, loops: int = 0) -> Errand[FollowWaypoints.Result]:
        """Return a visit of places, one after the other."""
        goal = FollowWaypoints.Goal(poses=[self.pose(target) for target in targets], number_of_loops=loops)
        return Errand("follow_waypoints", goal, FollowWaypoints.Result)

    def compute_path_to(self, target: Target, start: Target | None = None) -> Errand[ComputePathToPose.Result]:
        """Return the question for a path to a place."""
        goal = ComputePathToPose.Goal(goal=self.pose(target), **self._start(start))
        return Errand("compute_path_to_pose", goal, ComputePathToPose.Result)

    def compute_path_through(
        self, targets: Sequence[Target], start: Target | None = None
    ) -> Errand[ComputePathThroughPoses.Result]:
        """Return the question for a path through places."""
        goal = ComputePathThroughPoses.Goal(goals=self._goals(targets), **self._start(start))
        return Errand("compute_path_through_poses", goal, ComputePathThroughPoses.Result)

    def compute_route(self, target: Target, start: Target | None = None) -> Errand[ComputeRoute.Result]:
        """Return the question for a route along lanes."""
        goal = ComputeRoute.Goal(goal=self.pose(target), use_poses=True, **self._start(start))
        return Errand("compute_route", goal, ComputeRoute.Result)

    def track_route(self, target: Target) -> Errand[ComputeAndTrackRoute.Result]:
        """Return following the robot along a route, whatever drives it."""
        goal = ComputeAndTrackRoute.Goal(goal=self.pose(target), use_poses=True)
        return Errand("compute_and_track_route", goal, ComputeAndTrackRoute.Result)

    def follow_path(self, path: Path) -> Errand[FollowPath.Result]:
        """Return a drive along a path."""
        return Errand("follow_path", FollowPath.Goal(path=path), FollowPath.Result)

    def smooth_path(self, path: Path) -> Errand[SmoothPath.Result]:
        """Return the question for a smoother path."""
        return Errand("smooth_path", SmoothPath.Goal(path=path), SmoothPath.Result)

    def spin(self, yaw: float) -> Errand[Spin.Result]:
        """Return a turn on the spot."""
        return Errand("spin", Spin.Goal(target_yaw=yaw), Spin.Result)

    def back_up(self, distance: float, speed: float) -> Errand[BackUp.Result]:
        """Return a drive straight back."""
        return Errand("back_up", BackUp.Goal(target=Point(x=distance), speed=speed), BackUp.Result)

    def drive_on_heading(self, distance: float, speed: float) -> Errand[DriveOnHeading.Result]:
        """Return a drive straight on."""
        goal = DriveOnHeading.Goal(target=Point(x=distance), speed=speed)
        return Errand("drive_on_heading", goal, DriveOnHeading.Result)

    def dock(self, dock: str, *, navigate: bool = True) -> Errand[DockRobot.Result]:
        """Return docking at a dock."""
        goal = DockRobot.Goal(dock_id=dock, navigate_to_staging_pose=navigate)
        return Errand("dock_robot", goal, DockRobot.Result)

    def undock(self) -> Errand[UndockRobot.Result]:
        """Return undocking."""
        return Errand("undock_robot", UndockRobot.Goal(), UndockRobot.Result)

    def pickup(self, item: str) -> Errand[Pickup.Result]:
        """Return picking up an item."""
        return Errand("pickup", Pickup.Goal(target_name=item), Pickup.Result)

    def place(self, item: str) -> Errand[Place.Result]:
        """Return putting down an item."""
        return Errand("place", Place.Goal(attached_object_name=item), Place.Result)

    def wait(self, seconds: float) -> Errand[Wait.Result]:
        """Return standing still."""
        return Errand("wait", Wait.Goal(time=Duration.from_seconds(seconds)), Wait.Result)

    def any(self, action: AnyAction | str, goal: Message | Mapping[str, Any]) -> Errand[Any]:
        """Return a goal of any action, such as one of a package.

        Raises:
            ValueError: No action of this name is installed, or there is no place of a name.
        """
        errand = Errand(action, goal, Message)
        if isinstance(goal, Message):
            return errand
        return replace(errand, goal=with_poses(goal, errand.definition.goal, self.pose))

    def _goals(self, targets: Sequence[Target]) -> Goals:
        return Goals(goals=[self.pose(target) for target in targets])

    def _start(self, start: Target | None) -> dict[str, Any]:
        return {} if start is None else {"start": self.pose(start), "use_start": True}


def pose_at(x: float, y: float, yaw: float = 0.0) -> PoseStamped:
    """Return a pose of the map; in the world's unit of length, and radians."""
    turned = Quaternion(z=math.sin(yaw / 2), w=math.cos(yaw / 2))
    return PoseStamped(pose=Pose(position=Point(x=float(x), y=float(y)), orientation=turned))
