"""Robots at docks."""

from __future__ import annotations

from typing import Annotated, Final

from pydantic import Field

from hmrsim.events._event import Event, EventGroup
from hmrsim.events._fields import RobotName, Whole
from hmrsim.events._parts import Part


class DockEvent(Event, changes=Part.DOCK):
    """Something about a robot and a dock."""

    robot: RobotName
    dock: Annotated[str, Field(description="The dock's name.")]


class DockQueued(
    DockEvent, kind="dock_queued", text="waits in the queue of {dock}, position {position}", sets={"state": "queued"}
):
    """A robot queues, as all berths of the dock are taken."""

    position: Annotated[Whole, Field(description="Its place in the queue, from 1.")]


class Docked(DockEvent, kind="dock_docked", text="docked at {dock}", sets={"state": "docked"}):
    """A robot is docked."""


class Undocked(DockEvent, kind="dock_undocked", text="undocked from {dock}", sets={"state": "away"}):
    """A robot has left its dock."""


EVENTS: Final = EventGroup("docks", (DockQueued, Docked, Undocked))
