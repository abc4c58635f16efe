"""The interface between robots and docks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from hmrsim.traffic.rules import Vehicle

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    from simpy import Event

    from hmrsim.components.battery import Battery
    from hmrsim.geometry import Point, Pose
    from hmrsim.world.model import Dock


class DockBay(Protocol):
    """A dock as robots, their batteries and docking actions see it."""

    @property
    def name(self) -> str:
        """The name in the world file."""

    @property
    def pose(self) -> Pose:
        """The pose of a docked robot."""

    @property
    def spec(self) -> Dock:
        """The settings in the world file."""

    @property
    def staging(self) -> Point:
        """The point where robots line up before they drive in."""

    @property
    def out_of_order(self) -> bool:
        """Return whether the dock is out of order: no robot can dock there, and none is charged."""

    def serves(self, robot: DockClient) -> bool:
        """Return whether a robot may dock here."""

    def power_for(self, battery: Battery) -> float:
        """Return the units of energy a second that it charges a battery with; 0 if it charges none."""

    def away(self, point: Point) -> float:
        """Return how far a point is from where robots stand in it."""

    def holds(self, point: Point) -> bool:
        """Return whether a point is in it, or between it and its staging pose."""

    def has_room_for(self, robot: DockClient) -> bool:
        """Return whether a robot may dock here, and a bay is free."""

    def reserve(self, robot: DockClient) -> AbstractContextManager[Event]:
        """Reserve a bay for a robot, as soon as one is free, until it is docked there or gives up."""

    def take_in(self, robot: DockClient) -> None:
        """Dock a robot that stands here."""

    def release(self, robot: DockClient) -> None:
        """Release the dock, which a robot leaves."""


class DockClient(Vehicle, Protocol):
    """A robot as docks see it."""

    def enter_dock(self, dock: DockBay) -> None:
        """Be docked, and charge if the dock is a charger."""

    def leave_dock(self) -> None:
        """Clear the dock at which the robot is."""

    def dock_changed(self) -> None:
        """Record whether the dock charges the robot."""
