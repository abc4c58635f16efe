"""Lifts that move."""

from __future__ import annotations

from typing import Annotated, Final

from pydantic import Field

from hmrsim.events._event import Event, EventGroup
from hmrsim.events._parts import Part

_Stop = Annotated[str, Field(description="The stop, by the name of its waypoint.")]
_Robots = Annotated[tuple[str, ...], Field(description="The names of the robots in it.")]


class LiftEvent(Event, subject=("lift",)):
    """Something about a lift."""

    lift: Annotated[str, Field(description="The lift's name.")]


class LiftCalled(LiftEvent, kind="lift_called", severity="debug", text="is called to {stop}[ by {by}]"):
    """A lift is called to a stop."""

    stop: _Stop
    by: Annotated[str, Field(description="The robot that calls it; left out for a service's call.")] = ""


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


EVENTS: Final = EventGroup("lifts", (LiftCalled, LiftDeparted, LiftArrived))
