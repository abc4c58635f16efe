"""Robots at docks."""

from __future__ import annotations

from typing import Annotated, Final

from pydantic import Field

from hmrsim.events._event import Event, EventGroup
from hmrsim.events._fields import RobotName, Whole
from hmrsim.events._parts import Part

_DockName = Annotated[str, Field(description="The dock's name.")]


class DockQueued(
    Event,
    kind="dock_queued",
    text="waits in the queue of {dock}, position {position}",
    changes=Part.DOCK,
    sets={"state": "queued"},
):
    """A robot queues, as all berths of the dock are taken."""

    robot: RobotName
    dock: _DockName
    position: Annotated[Whole, Field(description="Its place in the queue, from 1.")]


class Docked(Event, kind="dock_docked", text="docked at {dock}", changes=Part.DOCK, sets={"state": "docked"}):
    """A robot is docked."""

    robot: RobotName
    dock: _DockName


class Undocked(Event, kind="dock_undocked", text="undocked from {dock}", changes=Part.DOCK, sets={"state": "away"}):
    """A robot has left its dock."""

    robot: RobotName
    dock: _DockName


EVENTS: Final = EventGroup("docks", (DockQueued, Docked, Undocked))
