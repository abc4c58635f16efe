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
    """The part of a dock that robots, their batteries and docking actions use."""

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
        """The point where robots wait, and from which they drive in."""

    @property
    def out_of_order(self) -> bool:
        """Whether the dock is out of order: no robot can dock, and none is charged."""

    def serves(self, robot: DockClient) -> bool:
        """Return whether a robot may dock here."""

    def power_for(self, battery: Battery) -> float:
        """Return the power with which it charges a battery, in units of energy per second; 0 if it does not."""

    def away(self, point: Point) -> float:
        """Return the distance of a point from the docked pose."""

    def holds(self, point: Point) -> bool:
        """Return whether a point is in the dock, or between it and its staging point."""

    def has_room_for(self, robot: DockClient) -> bool:
        """Return whether a robot may dock here, and a bay is free."""

    def reserve(self, robot: DockClient) -> AbstractContextManager[Event]:
        """Request a bay for a robot, which keeps it until it is docked or gives up."""

    def take_in(self, robot: DockClient) -> None:
        """Dock a robot that stands in the dock."""

    def release(self, robot: DockClient) -> None:
        """Release the bay of a robot that leaves."""


class DockClient(Vehicle, Protocol):
    """The part of a robot that docks use."""

    def enter_dock(self, dock: DockBay) -> None:
        """Record that it is docked; it charges if the dock is a charger."""

    def leave_dock(self) -> None:
        """Record that it has left its dock."""

    def dock_changed(self) -> None:
        """Start or stop charging, as the dock requires."""
