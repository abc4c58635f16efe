"""Faults that can be injected. One kind of fault is one file.

A fault is data: a name, its settings, and a function that begins it and returns what ends it. The schedule of a world,
the services and the tests are generic over it. When faults begin is decided in `hmrsim.simulation.fault_injector`.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import TYPE_CHECKING, Annotated, Any, Generic, Literal, Protocol, Self, TypeVar

from pydantic import BaseModel, ConfigDict, Field, model_validator

from hmrsim.distributions import PositiveRandomSeconds, RandomSeconds, latest
from hmrsim.events import EventPattern
from hmrsim.events.faults import FaultEvent
from hmrsim.plugins import discover

if TYPE_CHECKING:
    import random

    from hmrsim.components.claw import Claw
    from hmrsim.events import Event
    from hmrsim.robots.robot import Robot
    from hmrsim.traffic.admission import Admission


_MAX = 1e9

Seconds = Annotated[float, Field(strict=True, ge=0, le=_MAX, json_schema_extra={"unit": "s"})]


class Anchor(EventPattern):
    """The event a fault waits for: an event with values of its fields, or a change of a goal.

    Attributes:
        event: A kind of event, such as ``picked``.
        where: Values of its fields, as its JSON has them; all must be equal.
        goal: The change of a goal; ``ended`` stands for succeeded, canceled and aborted.
        action: The action of that goal; omitted for any.
        robot: The robot of the event or goal; omitted for any.
        nth: The number of the matching event, from 1, since the start of the run, a reset or the fault's injection.
        after: Simulated seconds from the event to the fault; with 0 the fault begins later in the same instant.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True, allow_inf_nan=False)

    nth: Annotated[int, Field(strict=True, ge=1)] = 1
    after: Seconds = 0.0

    def describe(self) -> str:
        """Return the anchor in words, such as ``0.5 s after pickup of eve is executing (number 2)``."""
        delay = f"{self.after:g} s after " if self.after else ""
        what = super().describe()
        if self.event is not None and self.robot:
            what = f"{self.robot} reports {EventPattern(event=self.event, where=self.where).describe()}"
        return f"{delay}{what}{f' (number {self.nth})' if self.nth > 1 else ''}"


SUBJECTS = FaultEvent.presentation.subject
"""The fields that name the subject of a fault."""

_IN_GENERAL = frozenset({"name", "at", "mean_time_between", "until", "duration", "mean_duration"})
"""The fields that all faults have; a form shows them after those of the kind."""

_NOT_ASKED = frozenset({"when"})
"""The fields that a form does not ask for: people at a page inject a fault when they see the event themselves."""

_TITLES = {"at": "Start time", "until": "End time", "mean_time_between": "Mean time between faults", "yaw": "Rotation"}

Name = Annotated[str, Field(min_length=1, max_length=100)]
SomeSeconds = Annotated[float, Field(strict=True, gt=0, le=_MAX, json_schema_extra={"unit": "s"})]
MeanSeconds = Annotated[float, Field(strict=True, ge=0.001, le=_MAX, json_schema_extra={"unit": "s"})]
"""Mean seconds between recurring faults; simulated time would never advance if they could be 0."""

_IN_SECONDS = Field(json_schema_extra={"unit": "s"})
Probability = Annotated[float, Field(strict=True, gt=0, le=1)]


class Occurrence(BaseModel):
    """The settings of every fault: when it happens. A fault that is not a `Spell` is instantaneous."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True, allow_inf_nan=False)

    name: Name | None = Field(
        default=None, description="The fault's name in events and for clearing it; None for its type and a number."
    )
    at: Annotated[RandomSeconds, _IN_SECONDS] | None = Field(
        default=None, description="When the fault begins, in simulated seconds; None for immediately."
    )
    mean_time_between: MeanSeconds | None = Field(
        default=None,
        description="Mean seconds before the fault begins, and from its end until it recurs; None to begin once.",
    )
    when: Anchor | None = Field(
        default=None, description="The event after which the fault begins, instead of a time; None for no event."
    )

    @property
    def subject(self) -> str:
        """The target: the name of a robot, an item or a part of the building, or the waypoints of a lane."""
        said = self.__dict__
        for name in SUBJECTS:
            if value := said.get(name):
                return value if isinstance(value, str) else "-".join(value)
        return ""

    @model_validator(mode="after")
    def _one_beginning(self) -> Self:
        given = [name for name in ("at", "mean_time_between", "when") if getattr(self, name) is not None]
        if len(given) > 1:
            raise ValueError(f"{' and '.join(given[:2])} are both given; leave one of them out")
        return self


class Spell(Occurrence):
    """The settings of a fault that lasts for a while; without an end it lasts forever."""

    until: Seconds | None = Field(default=None, description="When the fault ends, in simulated seconds.")
    duration: Annotated[PositiveRandomSeconds, _IN_SECONDS] | None = Field(
        default=None, description="How long the fault lasts, in seconds."
    )
    mean_duration: MeanSeconds | None = Field(
        default=None, description="How long the fault lasts on average, in seconds."
    )

    @model_validator(mode="after")
    def _one_end(self) -> Self:
        ends = [name for name in ("until", "duration", "mean_duration") if getattr(self, name) is not None]
        if len(ends) > 1:
            raise ValueError(f"{' and '.join(ends)} are both given; leave one of them out")
        if self.until is not None and self.mean_time_between is not None:
            raise ValueError("until is given for a fault that recurs; give duration or mean_duration")
        if self.until is not None and self.when is not None:
            raise ValueError("until is given for a fault that begins when an event comes; give duration")
        latest_at = 0.0 if self.at is None else latest(self.at)
        if self.until is not None and self.until <= latest_at:
            raise ValueError(f"until {self.until:g} s is not after at {latest_at:g} s")
        return self


S = TypeVar("S", bound=Occurrence)


class GoalSite(Protocol):
    """The goals of robots as faults see them. Each method returns what ends its effect."""

    def reject(
        self, robot: str, action: str | None, *, reason: str, why: str, done: Callable[[], None]
    ) -> Callable[[], None]:
        """Reject goals of an action, or of all if it is None, for a reason and a text; *done* is called with each."""

    def abort(
        self,
        robot: str,
        action: str | None,
        *,
        code: int | None,
        why: str,
        cause: str,
        delay: float,
        done: Callable[[], None],
    ) -> Callable[[], None]:
        """Abort goals some seconds after they began to execute; return a function that ends it."""


class FaultSite(Protocol):
    """The entities of a world as faults see them."""

    def delete(self, name: str) -> None:
        """Remove an entity from the world; a robot that carries an item holds it no longer."""

    @property
    def robots(self) -> Mapping[str, Robot]:
        """All robots of the world, by name."""

    @property
    def fixtures(self) -> Mapping[str, Any]:
        """Docks, doors and lifts, by name."""

    @property
    def admission(self) -> Admission:
        """The traffic admission, which lets robots onto lanes and closes lanes."""

    @property
    def goals(self) -> GoalSite:
        """The goals of the robots."""

    def connect(self, name: str, *, connected: bool) -> None:
        """Connect a robot to the network, or disconnect it."""

    def delay_news(self, name: str, seconds: float) -> Callable[[], None]:
        """Delay the status and results of a robot's goals; return the function that ends the delay."""

    def publish(self, make: Callable[[], Event]) -> None:
        """Publish an event of this instant; it is made only if it is wanted."""


@dataclass(frozen=True)
class Case(Generic[S]):
    """One occurrence of a fault.

    Attributes:
        roster: The robots, items, doors and lanes of the world.
        random: Its own stream of random numbers.
        concurrent: Returns the settings of other faults of this kind that are active on the same subject, in order of
            their beginnings.
        finish: Ends it before its time, at this instant: it has done what it can do.
    """

    name: str
    settings: S
    roster: FaultSite
    random: random.Random
    concurrent: Callable[[], Sequence[S]]
    finish: Callable[[], None]

    @property
    def robot(self) -> Robot:
        """The robot that it affects."""
        return self.roster.robots[self.settings.subject]

    @property
    def claw(self) -> Claw:
        """The claw of the affected robot."""
        claw: Claw = self.robot.components["claw"]
        return claw

    def publish(self, make: Callable[[], Event]) -> None:
        """Publish an event of the fault's own; it is made only if it is wanted."""
        self.roster.publish(make)

    def happens(self, probability: float) -> bool:
        """Return True with a probability."""
        return self.random.random() < probability


@dataclass(frozen=True)
class FaultType(Generic[S]):
    """A kind of fault that can be injected.

    Attributes:
        name: As in world files, and that of its module.
        settings: The model of its settings. A field named as one of `SUBJECTS` names the subject, which must exist when
            the fault begins.
        begin: Begins it; returns what ends it.
        component: The component that the robot needs; None for none.
        example: Valid settings in the world of the contract tests, in plain values.
        title: Its name for users; empty for its name in words.
        text: What happens, with fields of its settings, as for `str.format`; empty to list the settings.
        changes: The fields of a snapshot that it changes beside those its events change: ``ailments``, ``connected``,
            ``sensors`` or ``speed`` of its robot, or ``jammed`` of its door; empty for nothing.
    """

    name: str
    settings: type[S]
    begin: Callable[[Case[S]], Callable[[], None]]
    component: str | None = None
    example: Mapping[str, Any] = field(default_factory=dict)
    title: str = ""
    text: str = ""
    changes: Literal["", "ailments", "connected", "sensors", "speed", "jammed"] = ""

    def form(self) -> dict[str, Any]:
        """Return the JSON Schema of the form that injects it; ``subject`` names what it is injected into."""
        about = inspect.getmodule(self.begin)
        text = inspect.getdoc(about) or "" if about else ""
        schema = self.settings.model_json_schema()
        fields = schema["properties"]
        subject = next((name for name in SUBJECTS if fields.pop(name, None)), "")
        return {
            "title": self.title or _in_words(self.name),
            "description": text.partition("\n")[0],
            "type": "object",
            "subject": subject,
            **({"component": self.component} if self.component else {}),
            **({"changes": self.changes} if self.changes else {}),
            "properties": {
                name: self._shown(name, fields[name])
                for name in sorted(fields, key=_IN_GENERAL.__contains__)
                if name not in _NOT_ASKED
            },
            "required": [name for name in schema.get("required", ()) if name != subject],
        }

    def _shown(self, name: str, part: dict[str, Any]) -> dict[str, Any]:
        """Return the schema of a field without the alternative null: an empty field is left out."""
        value: dict[str, Any] = next((each for each in part.get("anyOf", ()) if each.get("type") != "null"), {})
        said = {key: each for key, each in {**value, **part}.items() if key != "anyOf" and each is not None}
        # Of a number or a distribution a form asks for the number.
        value = said.pop("oneOf", [{}])[0]
        titled: dict[str, Any] = {"title": _TITLES.get(name) or _in_words(name)}
        if name in _IN_GENERAL and name != "duration":
            titled["advanced"] = True
        return {**({"default": self.example[name]} if name in self.example else {}), **value, **said, **titled}

    @property
    def lasts(self) -> bool:
        """Return whether the fault lasts for some time instead of ending at the instant it begins."""
        return issubclass(self.settings, Spell)


def _in_words(name: str) -> str:
    return name.replace("_", " ").capitalize()


AnyFault = FaultType[Any]


__all__ = [
    "SUBJECTS",
    "Anchor",
    "AnyFault",
    "Case",
    "FaultSite",
    "FaultType",
    "GoalSite",
    "Name",
    "Occurrence",
    "Probability",
    "Seconds",
    "SomeSeconds",
    "Spell",
    "registry",
]


@cache
def registry() -> dict[str, AnyFault]:
    """Return all faults by name."""
    return discover(sys.modules[__name__], "FAULT", FaultType)
