"""Events of the simulation: its state, entities, participants in lockstep, planner and violated properties."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Final

from pydantic import Field

from hmrsim.events._event import Event, EventGroup, Number, Part, Position, RobotName, Whole


class SimulationStateChanged(
    Event,
    kind="simulation_state",
    subject=(),
    text="the simulation is [{state=0}stopped|{state=1}playing|{state=2}paused|in state {state}]",
    changes=Part.STATE,
):
    """The simulation was paused, stopped, or set to play."""

    state: Annotated[
        Whole,
        Field(
            description="The state, as in simulation_interfaces/msg/SimulationState: 0 stopped, 1 playing, 2 paused."
        ),
    ]


class SimulationReset(Event, kind="reset", subject=(), text="the simulation was reset", changes=Part.SCENE):
    """A client has reset the simulation."""

    scope: Annotated[Whole, Field(description="The sum of 1 time, 2 state, 4 spawned; 255 for all.")]


class WorldLoaded(Event, kind="world_loaded", subject=(), text="the world {name} was loaded", changes=Part.WORLD):
    """A new world was loaded."""

    name: Annotated[str, Field(description="The world's name.")]


class RunReported(Event, kind="run_reported", subject=(), text="a controller reports {label}", rest="values"):
    """A controller reports the outcome of its run, by `end_run`."""

    label: Annotated[str, Field(description="The outcome, a word that the controller chooses.")]
    values: Annotated[dict[str, Any], Field(description="Further values, by name.")]


class SimulatorReturned(
    Event, kind="simulator_returned", severity="warning", subject=(), text="the simulator can be reached again"
):
    """The recorder can reach the simulator again after it could not; only in recordings."""


class InternalError(Event, kind="internal_error", severity="error", text="bug in {part}: {error}"):
    """A bug of a plug-in or of hmrsim has raised an exception; the operation has failed, the simulation continues."""

    robot: Annotated[str, Field(description="The robot concerned; empty for none.")]
    part: Annotated[str, Field(description="The part with the bug, such as `action wait`.")]
    error: Annotated[str, Field(description="The exception on one line.")]


class UntracedError(InternalError, severity="error", text="bug in {part}: {error}", traced=False):
    """An internal error that a replay does not repeat, such as one of a sample for subscribers."""


class EntityEvent(Event, subject=("entity",), changes=Part.ENTITIES):
    """An event of a robot or an item."""

    entity: Annotated[str, Field(description="The name of the robot or item.")]


class Spawned(EntityEvent, kind="spawned", text="spawned as {type} at {at:point}", sets={"present": True}):
    """A robot or an item was spawned."""

    type: Annotated[str, Field(description="The robot's type, or `item`.")]
    at: Position


class Deleted(EntityEvent, kind="deleted", text="deleted", sets={"present": False}):
    """A robot or an item was deleted."""


class Teleported(EntityEvent, kind="teleported", text="teleported to {at:point}"):
    """A robot or an item was teleported."""

    at: Position
    yaw: Annotated[Number, Field(description="The yaw, in radians.")]


class ParticipantEvent(Event, subject=("participant",), changes=Part.PARTICIPANTS):
    """A change of the participants in lockstep."""

    participant: Annotated[str, Field(description="The participant's name.")]
    why: Annotated[str, Field(description="The reason, unless the controller left by itself.")] = ""


class ParticipantJoined(ParticipantEvent, kind="participant_joined", text="joins lockstep", sets={"present": True}):
    """A controller has joined lockstep."""


class ParticipantLeft(
    ParticipantEvent, kind="participant_left", text="leaves lockstep[: {why}]", sets={"present": False}
):
    """A controller has left lockstep."""


class ParticipantDropped(
    ParticipantEvent,
    kind="participant_dropped",
    severity="warning",
    text="is dropped from lockstep[: {why}]",
    sets={"present": False},
):
    """A controller was dropped because it did not answer in time."""


PARTICIPATION: Final[Mapping[str, type[ParticipantEvent]]] = {
    "joined": ParticipantJoined,
    "left": ParticipantLeft,
    "dropped": ParticipantDropped,
}
"""The event for each change of a participant."""


class PlanRequested(
    Event, kind="plan_wanted", severity="debug", text="requests a path from the external planner (request {request})"
):
    """A robot needs a path from the external planner."""

    robot: RobotName
    request: Annotated[Whole, Field(description="The number of the request.")]


class PlannerChanged(
    Event,
    kind="planner",
    severity="[{present=false}warning|info]",
    subject=(),
    text="[{present=true}an external planner is available|no external planner is available]",
    changes=Part.PLANNER,
):
    """The first external planner has become available, or the last one has gone."""

    present: Annotated[bool, Field(strict=True, description="Whether an external planner is available.")]


class PropertyViolated(
    Event,
    kind="property_violated",
    severity="error",
    subject=(),
    text="the property {property} is violated at {at} s: {text}",
    traced=False,
):
    """A watched property is violated. Traces omit the event, because not every run is watched."""

    property: Annotated[str, Field(description="The property's name.")]
    subject_: Annotated[str, Field(description="The robot, order or other subject that violates it; empty for none.")]
    at: Annotated[
        Number, Field(description="The simulated time of the violation, in seconds; a later event may reveal it.")
    ]
    reason: Annotated[str, Field(description="The reason, as a short text without times and identifiers.")]
    text_: Annotated[str, Field(description="The reason, as a sentence.")]


EVENTS: Final = (
    EventGroup(
        "simulation",
        (SimulationStateChanged, SimulationReset, WorldLoaded, RunReported, SimulatorReturned, InternalError),
    ),
    EventGroup("entities", (Spawned, Deleted, Teleported)),
    EventGroup("participants", (ParticipantJoined, ParticipantLeft, ParticipantDropped)),
    EventGroup("planning", (PlanRequested, PlannerChanged)),
    EventGroup("properties", (PropertyViolated,)),
)
