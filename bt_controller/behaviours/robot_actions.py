"""Behaviors for a robot's usual actions: driving, docking, picking items up and placing them, waiting."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, Final

from bt_controller.behaviours.action_clients import FromConstant
from bt_controller.core.action_leaf import ActionLeaf
from bt_controller.core.robots import NotServed
from hmrsim.actions import dock_robot, navigate_to_pose, pickup, place, undock_robot, wait
from hmrsim.diagnostics import shown
from hmrsim.interfaces import moveit_msgs, nav2_msgs
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.message import unbuilt
from hmrsim.interfaces.nav2_msgs import DockRobot, NavigateToPose, UndockRobot
from hmrsim_zenoh.client.places import pose_at
from hmrsim_zenoh.errors import Unreachable

if TYPE_CHECKING:
    from bt_controller.core.action_leaf import GoalSource
    from bt_controller.core.ports import Places


_LENGTHS: Final = (2, 3)
"""Of x and y, and of yaw beside."""


class NavToPoseActionClient(ActionLeaf[NavigateToPose.Goal, NavigateToPose.Result, NavigateToPose.Feedback]):
    """Sends a goal of ``navigate_to_pose``; its feedback message is the remaining distance."""

    def __init__(
        self,
        name: str,
        goal: GoalSource[NavigateToPose.Goal],
        *,
        robot: str | None = None,
        on_success: Mapping[str, object] | None = None,
    ) -> None:
        super().__init__(name, navigate_to_pose.ACTION, goal, robot=robot, describe=_remaining, on_success=on_success)


class GoTo(NavToPoseActionClient):
    """Drives the robot to a place of the world: a waypoint, a place or a dock; or to a pose.

    ::

        GoTo("pharmacy")
        GoTo((6.0, 18.0), name="Go to the pharmacy")

    Args:
        target: The place's name; or x, y and, if it matters, yaw, in the world's unit of length and radians.
        name: The behavior's name; says the target if left out.
        robot: The robot that serves the action; None for the one that the tree is run for.

    Raises:
        TypeError: The target is neither.
    """

    def __init__(
        self,
        target: str | tuple[float, float] | tuple[float, float, float],
        *,
        name: str | None = None,
        robot: str | None = None,
    ) -> None:
        if not isinstance(target, str) and not (isinstance(target, Sequence) and len(target) in _LENGTHS):
            raise TypeError(f"GoTo takes the name of a place, (x, y) or (x, y, yaw), got {shown(target)}")
        self._place = target if isinstance(target, str) else None
        words = target if isinstance(target, str) else "({})".format(", ".join(f"{part:g}" for part in target))
        goal = None if isinstance(target, str) else NavigateToPose.Goal(pose=pose_at(*target))
        super().__init__(name or f"Go to {words}", lambda: goal, robot=robot)

    def setup(self, **kwargs: Any) -> None:
        """Look up the action and the place.

        Raises:
            NotServed: There is no such robot, action or place.
            SimulatorNotFound: No simulator answers.
        """
        super().setup(**kwargs)
        if self._place is not None:
            try:
                self._goal = NavigateToPose.Goal(pose=kwargs["places"].pose(self._place))
            except ValueError as error:
                raise NotServed(f"{self.name!r}: {error}") from None


def pose_goal(x: float, y: float) -> NavigateToPose.Goal:
    """Return the goal of a drive to a point, in the world's unit of length."""
    return NavigateToPose.Goal(pose=pose_at(x, y))


def _remaining(feedback: NavigateToPose.Feedback) -> str:
    return f"remaining: {feedback.distance_remaining}"


class Dock(FromConstant[DockRobot.Goal, DockRobot.Result, DockRobot.Feedback]):
    """Docks the robot; at a charger it succeeds as soon as the battery charges.

    Args:
        max_staging_time: Simulated seconds within which the robot has to reach the dock, including the wait for
            other robots to leave; 0 for no limit.
        name: The behavior's name; says the dock if left out.
        robot: The robot that serves the action; None for the one that the tree is run for.
    """

    def __init__(
        self, dock: str, *, max_staging_time: float = 0.0, name: str | None = None, robot: str | None = None
    ) -> None:
        goal = DockRobot.Goal(dock_id=dock, max_staging_time=max_staging_time)
        super().__init__(name or f"Dock at {dock}", dock_robot.ACTION, goal, robot=robot)
        self._dock = dock

    def setup(self, **kwargs: Any) -> None:
        """Look up the action and the dock.

        Raises:
            NotServed: There is no such robot, action or dock.
            SimulatorNotFound: No simulator answers.
        """
        super().setup(**kwargs)
        if why := missing_dock(self._dock, kwargs.get("places")):
            raise NotServed(f"{self.name!r}: {why}")


def missing_dock(dock: str, places: Places | None) -> str:
    """Return why a dock does not exist; empty if it exists or if that is unknown, as for a real robot."""
    if places is None:
        return ""
    try:
        places.pose(dock)
    except ValueError as error:
        return str(error)
    except Unreachable:
        return ""
    return ""


class Undock(FromConstant[UndockRobot.Goal, UndockRobot.Result, UndockRobot.Feedback]):
    """A leaf that undocks the robot.

    Args:
        robot: The robot that serves the action; None for the one that the tree is run for.
    """

    def __init__(self, *, name: str = "Undock", robot: str | None = None) -> None:
        super().__init__(name, undock_robot.ACTION, UndockRobot.Goal(), robot=robot)


class Pickup(ActionLeaf[Any, moveit_msgs.Pickup.Result, moveit_msgs.Pickup.Feedback]):
    """Picks up an item that is in reach.

    Args:
        name: The behavior's name; says the item if left out.
        robot: The robot that serves the action; None for the one that the tree is run for.

    Raises:
        TypeError: The item's name is no text.
    """

    PLAIN = True

    def __init__(self, item: str, *, name: str | None = None, robot: str | None = None) -> None:
        goal = partial(unbuilt, moveit_msgs.Pickup.Goal, target_name=item)
        super().__init__(name or f"Pick up {_checked(item)}", pickup.ACTION, goal, robot=robot)


class Place(ActionLeaf[Any, moveit_msgs.Place.Result, moveit_msgs.Place.Feedback]):
    """Puts down an item that the robot holds.

    Args:
        name: The behavior's name; says the item if left out.
        robot: The robot that serves the action; None for the one that the tree is run for.

    Raises:
        TypeError: The item's name is no text.
    """

    PLAIN = True

    def __init__(self, item: str, *, name: str | None = None, robot: str | None = None) -> None:
        goal = partial(unbuilt, moveit_msgs.Place.Goal, attached_object_name=item)
        super().__init__(name or f"Place {_checked(item)}", place.ACTION, goal, robot=robot)


def _checked(item: object) -> object:
    if not isinstance(item, str):
        raise TypeError(f"{item!r} is no item's name; a text is expected")
    return item


class Wait(FromConstant[nav2_msgs.Wait.Goal, nav2_msgs.Wait.Result, nav2_msgs.Wait.Feedback]):
    """Keeps the robot in place for a time, for instance while it works there.

    Args:
        seconds: Simulated seconds.
        name: The behavior's name; says how long if left out.
        robot: The robot that serves the action; None for the one that the tree is run for.
    """

    def __init__(self, seconds: float, *, name: str | None = None, robot: str | None = None) -> None:
        goal = nav2_msgs.Wait.Goal(time=Duration.from_seconds(seconds))
        super().__init__(name or f"Wait {seconds:g} s", wait.ACTION, goal, robot=robot)
