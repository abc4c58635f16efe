"""The state of the simulation, steps, reset, and other worlds."""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field

from hmrsim.interfaces.message import Bool, Message, String, UInt8, UInt64
from hmrsim.interfaces.quantities import STEPS
from hmrsim.interfaces.simulation_interfaces import messages
from hmrsim.interfaces.simulation_interfaces.messages import (
    Result,
    SimulationState,
    SimulatorFeatures,
    TagsFilter,
    WorldResource,
)


class GetSimulatorFeatures:
    """Ask what the simulator can do."""

    class Request(Message):
        """Nothing more."""

    class Response(Message):
        """Its features."""

        features: SimulatorFeatures = Field(default_factory=SimulatorFeatures)


class GetSimulationState:
    """Ask whether time moves."""

    class Request(Message):
        """Nothing more."""

    class Response(Message):
        """Whether it does."""

        state: SimulationState = Field(default_factory=SimulationState)
        result: Result = Field(default_factory=Result)


class SetSimulationState:
    """Let time move, or stand."""

    class Request(Message):
        """The state that is wanted."""

        state: SimulationState = Field(default_factory=SimulationState)

    class Response(Message):
        """What came of it."""

        ALREADY_IN_TARGET_STATE: ClassVar[int] = 101
        STATE_TRANSITION_ERROR: ClassVar[int] = 102
        INCORRECT_TRANSITION: ClassVar[int] = 103

        result: Result = Field(default_factory=Result)


class StepSimulation:
    """Let time move by some steps, then stand."""

    class Request(Message):
        """How many."""

        steps: Annotated[UInt64, STEPS] = 1

    class Response(Message):
        """What came of it, when they are done."""

        result: Result = Field(default_factory=Result)


class SimulateSteps:
    """Let time move by some steps, then stand, and tell of each."""

    class Goal(Message):
        """How many."""

        steps: UInt64 = 0

    class Result(Message):
        """What came of it."""

        result: messages.Result = Field(default_factory=messages.Result)

    class Feedback(Message):
        """How many are done, and how many are left."""

        completed_steps: UInt64 = 0
        remaining_steps: UInt64 = 0


class ResetSimulation:
    """Begin anew."""

    class Request(Message):
        """What of it: scopes are bits."""

        SCOPE_DEFAULT: ClassVar[int] = 0
        SCOPE_TIME: ClassVar[int] = 1
        SCOPE_STATE: ClassVar[int] = 2
        SCOPE_SPAWNED: ClassVar[int] = 4
        SCOPE_ALL: ClassVar[int] = 255

        scope: UInt8 = 0

    class Response(Message):
        """What came of it."""

        result: Result = Field(default_factory=Result)


class LoadWorld:
    """Replace the world."""

    class Request(Message):
        """By which: a file or a name, or else the world's text itself."""

        uri: String = ""
        resource_string: String = ""
        fail_on_unsupported_element: Bool = False
        ignore_missing_or_unsupported_assets: Bool = False

    class Response(Message):
        """What came of it, and the world that is there now."""

        UNSUPPORTED_FORMAT: ClassVar[int] = 101
        NO_RESOURCE: ClassVar[int] = 102
        RESOURCE_PARSE_ERROR: ClassVar[int] = 103
        MISSING_ASSETS: ClassVar[int] = 104
        UNSUPPORTED_ASSETS: ClassVar[int] = 105
        UNSUPPORTED_ELEMENTS: ClassVar[int] = 106

        result: Result = Field(default_factory=Result)
        world: WorldResource = Field(default_factory=WorldResource)


class GetCurrentWorld:
    """Ask for the world that is there."""

    class Request(Message):
        """Nothing more."""

    class Response(Message):
        """The world."""

        NO_WORLD_LOADED: ClassVar[int] = 101

        result: Result = Field(default_factory=Result)
        world: WorldResource = Field(default_factory=WorldResource)


class GetAvailableWorlds:
    """Ask which worlds could be loaded."""

    class Request(Message):
        """Where to look for more, and of which tags."""

        additional_sources: list[String] = Field(default_factory=list)
        filter: TagsFilter = Field(default_factory=TagsFilter)
        offline_only: Bool = False
        continue_on_error: Bool = False

    class Response(Message):
        """Which."""

        DEFAULT_SOURCES_FAILED: ClassVar[int] = 101

        result: Result = Field(default_factory=Result)
        worlds: list[WorldResource] = Field(default_factory=list)
