"""Events of doors and lifts."""

from __future__ import annotations

from typing import Annotated, Final

from pydantic import Field

from hmrsim.events._event import Event, EventGroup, Part

_By = Annotated[str, Field(description="The robot for which it opens; omitted if a client opens it.")]


class DoorEvent(Event, subject=("door",), changes=Part.DOOR):
    """An event of a door."""

    door: Annotated[str, Field(description="The door's name.")]


class DoorOpening(DoorEvent, kind="door_opening", severity="debug", text="opens[ for {by}]", sets={"state": "opening"}):
    """A door begins to open."""

    by: _By = ""


class DoorOpened(
    DoorEvent, kind="door_opened", severity="debug", text="is open[ for {by}]", sets={"state": "open", "locked": False}
):
    """A door has opened completely."""

    by: _By = ""


class DoorClosed(DoorEvent, kind="door_closed", severity="debug", text="is closed", sets={"state": "closed"}):
    """A door has closed completely."""


_Stop = Annotated[str, Field(description="The stop, by the name of its waypoint.")]
_Robots = Annotated[tuple[str, ...], Field(description="The names of the robots in it.")]


class LiftEvent(Event, subject=("lift",)):
    """An event of a lift."""

    lift: Annotated[str, Field(description="The lift's name.")]


class LiftCalled(LiftEvent, kind="lift_called", severity="debug", text="is called to {stop}[ by {by}]"):
    """A lift is called to a stop."""

    stop: _Stop
    by: Annotated[str, Field(description="The robot that calls it; omitted for a service's call.")] = ""


class LiftDeparted(
    LiftEvent,
    kind="lift_departed",
    severity="debug",
    text="leaves {from} for {to}[ with {robots:and}]",
    changes=Part.LIFT,
    sets={"moves": True},
):
    """A lift leaves a stop."""

    from_: Annotated[_Stop, Field(description="The stop that it leaves.")]
    to: Annotated[_Stop, Field(description="The stop to which it goes.")]
    robots: _Robots


class LiftArrived(
    LiftEvent,
    kind="lift_arrived",
    severity="debug",
    text="arrives at {stop}[ with {robots:and}]",
    changes=Part.LIFT,
    sets={"moves": False},
):
    """A lift arrives at a stop."""

    stop: _Stop
    robots: _Robots


DOORS: Final = EventGroup("doors", (DoorOpening, DoorOpened, DoorClosed))
LIFTS: Final = EventGroup("lifts", (LiftCalled, LiftDeparted, LiftArrived))
EVENTS: Final = (DOORS, LIFTS)
