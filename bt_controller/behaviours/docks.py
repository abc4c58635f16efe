"""Behaviors that dock and undock the robot."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from bt_controller.behaviours.action_clients import FromConstant
from bt_controller.world.directory import NotServed
from hmrsim.actions import dock_robot, undock_robot
from hmrsim.interfaces.nav2_msgs import DockRobot, UndockRobot
from hmrsim_zenoh.errors import Unreachable

if TYPE_CHECKING:
    from bt_controller.core.ports import Places


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
    """Return why there is no such dock; empty if there is one, or if nobody knows, as of a real robot."""
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
    """Undocks the robot.

    Args:
        robot: The robot that serves the action; None for the one that the tree is run for.
    """

    def __init__(self, *, name: str = "Undock", robot: str | None = None) -> None:
        super().__init__(name, undock_robot.ACTION, UndockRobot.Goal(), robot=robot)
