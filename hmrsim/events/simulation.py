"""The simulation as a whole."""

from __future__ import annotations

from typing import Annotated, Any, Final

from pydantic import Field

from hmrsim.events._event import Event, EventGroup
from hmrsim.events._fields import Whole
from hmrsim.events._parts import Part


class SimulationStateChanged(
    Event,
    kind="simulation_state",
    subject=(),
    text="the simulation is [{state=0}stopped|{state=1}playing|{state=2}paused|in state {state}]",
    changes=Part.STATE,
):
    """The simulation was paused, stopped, or set to play."""

    state: Annotated[
        Whole, Field(description="Of simulation_interfaces/msg/SimulationState: 0 stopped, 1 playing, 2 paused.")
    ]


class SimulationReset(Event, kind="reset", subject=(), text="the simulation was reset", changes=Part.SCENE):
    """The simulation was reset."""

    scope: Annotated[Whole, Field(description="The sum of 1 time, 2 state, 4 spawned; 255 for all.")]


class WorldLoaded(Event, kind="world_loaded", subject=(), text="the world {name} was loaded", changes=Part.WORLD):
    """Another world was loaded."""

    name: Annotated[str, Field(description="The world's name.")]


class RunReported(Event, kind="run_reported", subject=(), text="a controller reports {label}", rest="values"):
    """A controller reports how its run has ended, by `end_run`."""

    label: Annotated[str, Field(description="How: a word of the controller's own.")]
    values: Annotated[dict[str, Any], Field(description="Further values, by name.")]


class SimulatorReturned(
    Event, kind="simulator_returned", severity="warning", subject=(), text="the simulator can be reached again"
):
    """The recorder can reach the simulator again after it could not; only in recordings."""


class InternalError(Event, kind="internal_error", severity="error", text="bug in {part}: {error}"):
    """A bug, of a plug-in or of hmrsim, has raised an exception; what it concerns has failed, all else goes on."""

    robot: Annotated[str, Field(description="The robot concerned; empty for none.")]
    part: Annotated[str, Field(description="What has the bug, such as `action wait`.")]
    error: Annotated[str, Field(description="The exception on one line.")]


class UntracedError(InternalError, severity="error", text="bug in {part}: {error}", traced=False):
    """The same of what a replay does not repeat, such as a sample for subscribers: a trace must not depend on them."""


EVENTS: Final = EventGroup(
    "simulation", (SimulationStateChanged, SimulationReset, WorldLoaded, RunReported, SimulatorReturned, InternalError)
)
