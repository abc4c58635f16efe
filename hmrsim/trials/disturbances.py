"""Disturbances of a controller and of its connection: their model, and the sink that triggers them."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal, NamedTuple, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from hmrsim.engine.sim_time import stamp
from hmrsim.errors import SimulationStopped
from hmrsim.events import registry
from hmrsim.faults import Anchor
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.interfaces.simulation_interfaces import ResetSimulation
from hmrsim.protocol.commands import CallService
from hmrsim.protocol.outputs import EventStamped, GoalChanged, TimeRestarted
from hmrsim.protocol.sinks import SelectiveSink
from hmrsim.protocol.topics import Topic

if TYPE_CHECKING:
    from hmrsim.diagnostics import Finding
    from hmrsim.events import Event
    from hmrsim.protocol.outputs import Output
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.timing.pacing import Pacing

Kind = Literal[
    "controller_killed",
    "controller_stalled",
    "second_controller",
    "reply_lost",
    "request_repeated",
    "simulation_reset",
]

_OF_KINDS: Final[Mapping[str, str]] = MappingProxyType(
    {
        "restart_after": "controller_killed",
        "duration": "controller_stalled",
        "count": "reply_lost and request_repeated",
    }
)
"""The kinds to which a setting belongs."""

_MAX = 1e9


class Disturbance(BaseModel):
    """A disturbance of a controller or of its connection, which happens once."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    disturbance: Kind = Field(description="What happens.")
    when: Anchor = Field(description="The event after which it happens.")
    restart_after: Annotated[float, Field(strict=True, ge=0, le=_MAX, json_schema_extra={"unit": "s"})] | None = Field(
        default=None, description="After how long a killed controller is started again; left out for never."
    )
    duration: Annotated[float, Field(strict=True, gt=0, le=_MAX, json_schema_extra={"unit": "s"})] | None = Field(
        default=None, description="How long a controller is stalled."
    )
    count: Annotated[int, Field(strict=True, ge=1, le=10_000)] | None = Field(
        default=None, description="How many answers get lost, or requests come twice; 1 if left out."
    )

    @model_validator(mode="after")
    def _settings_of_its_kind(self) -> Self:
        for name, kinds in _OF_KINDS.items():
            if getattr(self, name) is not None and self.disturbance not in kinds.split(" and "):
                raise ValueError(f"{name} belongs to {kinds}, not to {self.disturbance}; leave it out")
        if self.disturbance == "controller_stalled" and self.duration is None:
            raise ValueError("controller_stalled needs a duration, in simulated seconds")
        return self

    def flaws(self) -> Iterator[Finding]:
        """Yield the flaws that it has in any world: kinds and fields of events that do not exist."""
        for finding in self.when.flaws():
            yield finding.within("when")

    def describe(self) -> str:
        """Return it in words, such as ``the controller is killed: 0.5 s after pickup of eve is executing``."""
        return f"{self.what}: {self.when.describe()}"

    @property
    def what(self) -> str:
        """The effect in words, such as ``the controller is killed``."""
        number = self.count or 1
        match self.disturbance:
            case "controller_killed" if self.restart_after is None:
                what = "the controller is killed"
            case "controller_killed":
                what = f"the controller is killed, and started again after {self.restart_after:g} s"
            case "controller_stalled":
                what = f"the controller is stalled for {self.duration:g} s"
            case "second_controller":
                what = "a second controller is started"
            case "reply_lost":
                what = "the next answer is lost" if number == 1 else f"the next {number} answers are lost"
            case "request_repeated":
                what = "the next request comes twice" if number == 1 else f"the next {number} requests come twice"
            case _:
                what = "the simulation is reset"
        return what


class Acted(NamedTuple):
    """A disturbance that has happened.

    Attributes:
        at: When, in nanoseconds of simulated time.
    """

    at: int
    disturbance: Disturbance


class Disturber(SelectiveSink):
    """A sink that triggers the disturbances of one run, each once and at the end of an instant.

    Events are counted over the whole run, including resets of the simulation.

    Args:
        on_act: Called with each disturbance just before it is carried out.

    Attributes:
        acted: The disturbances that have happened, in order.
    """

    def __init__(
        self, disturbances: Sequence[Disturbance] = (), on_act: Callable[[Acted], object] = lambda _acted: None
    ) -> None:
        self.acted: list[Acted] = []
        self._on_act = on_act
        self._waiting = [_Waiting(each) for each in disturbances]
        self._kinds = frozenset(each.when.kind for each in disturbances)
        self._wants_motion = any(kind in registry() and not registry()[kind].traced for kind in self._kinds)
        self._simulator: Simulator | None = None
        self._pacing: Pacing | None = None
        self._act: Callable[[Disturbance], None] = lambda _disturbance: None

    @property
    def disturbances(self) -> list[Disturbance]:
        """The disturbances, in the order of the schedule."""
        return [each.disturbance for each in self._waiting]

    @property
    def began(self) -> list[float | None]:
        """When each disturbance has happened, in order and in simulated seconds; None for one that has not."""
        return [each.happened for each in self._waiting]

    def watch(self, simulator: Simulator, pacing: Pacing) -> Disturber:
        """Start to wait for the events of a simulator; return this sink."""
        self._simulator, self._pacing = simulator, pacing
        return self

    def attach(self, act: Callable[[Disturbance], None]) -> None:
        """Set the function that carries out disturbances, except resets, which this sink carries out itself.

        *act* is called in the simulation's thread, at the end of an instant.
        """
        self._act = act

    @property
    def topics(self) -> Collection[Topic]:
        """The topics that are wanted: events, and motions if a disturbance begins with one."""
        if not self._waiting:
            return ()
        return (Topic.EVENTS, Topic.MOTION) if self._wants_motion else (Topic.EVENTS,)

    def handler_for(self, kind: type) -> Callable[[Any], object] | None:
        """Return the function that processes outputs of a type; None to ignore them."""
        return self.emit if kind in (EventStamped, GoalChanged, TimeRestarted) else None

    def emit(self, output: Output) -> None:
        """Trigger the disturbances that wait for an event."""
        if isinstance(output, TimeRestarted):
            self._set_alarms_anew(output.ended)
            return
        for event in self._events(output):
            for each in self._waiting:
                if each.comes_with(event):
                    self._expect(each, each.disturbance.when.after)

    def _events(self, output: Output) -> Iterator[Event]:
        """Yield the events of an output whose kinds a disturbance waits for."""
        if isinstance(output, EventStamped):
            if output.kind in self._kinds:
                yield output.event
        elif isinstance(output, GoalChanged):
            if "status" in self._kinds:
                yield output.event()
            if output.goal is not None and "goal" in self._kinds:
                yield output.accepted()

    def _expect(self, waiting: _Waiting, after: float) -> None:
        """Carry out a disturbance after some seconds."""
        if self._simulator is None:
            raise AssertionError
        waiting.due = self._simulator.now + after
        if after > 0.0:
            # A trace has whole nanoseconds, and its replay has to come to the same time.
            waiting.due = math.ceil(waiting.due * NANOSECONDS) / NANOSECONDS
            self._simulator.env.alarm_at(waiting.due, partial(self._intervene, waiting))
        else:
            self._intervene(waiting)

    def _intervene(self, waiting: _Waiting) -> None:
        if self._pacing is not None and waiting.due is not None:
            waiting.due = None
            # After the end of the run nothing can be disturbed.
            with suppress(SimulationStopped):
                self._pacing.intervene(partial(self._carry_out, waiting))

    def _carry_out(self, waiting: _Waiting) -> None:
        if self._simulator is None or self._pacing is None:
            raise AssertionError
        disturbance, waiting.happened = waiting.disturbance, self._simulator.now
        self.acted.append(Acted(stamp(self._simulator.now), disturbance))
        self._on_act(self.acted[-1])
        if disturbance.disturbance == "simulation_reset":
            self._pacing.submit(CallService("reset_simulation", ResetSimulation.Request()))
        else:
            self._act(disturbance)

    def _set_alarms_anew(self, ended: int) -> None:
        """Set the alarms again that a reset of the simulation dropped, with the rest of their delays."""
        for each in self._waiting:
            if each.due is not None:
                self._expect(each, max(each.due - ended / NANOSECONDS, 0.0))


class _Waiting:
    """A disturbance that waits for its event, or for its time.

    Attributes:
        due: The time at which it is due, in simulated seconds, once its event has come.
        happened: The time at which it happened, in simulated seconds; None if it has not.
    """

    def __init__(self, disturbance: Disturbance) -> None:
        self.disturbance = disturbance
        self.due: float | None = None
        self.happened: float | None = None
        self._left = disturbance.when.nth

    def comes_with(self, event: Event) -> bool:
        """Count an event that matches; return whether it is the one that triggers the disturbance."""
        if self._left == 0 or not self.disturbance.when.matches(event):
            return False
        self._left -= 1
        return self._left == 0
