"""Conditions: what may hold at an instant of a run. A field named ``robot`` may be ``*``, for each robot."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated, Any, Final, Literal, Self

from pydantic import BaseModel, BeforeValidator, Discriminator, Field, Tag, model_validator

from hmrsim.diagnostics import listed, meant, shown
from hmrsim.events import EventPattern
from hmrsim.properties.model.part import Name, Part

RobotState = Literal["idle", "busy", "driving", "waiting", "charging", "stopped", "offline"]
"""The states of a robot, as reports name them."""

DoorState = Literal["open", "closed", "opening", "jammed"]
OrderState = Literal["waiting", "carried", "delivered", "lost", "late"]

Share = Annotated[float, Field(strict=True, ge=0, le=1)]


class RobotCondition(Part):
    """A robot is at a place, in a state, or both.

    Attributes:
        at: A place, dock or waypoint, nearer to it than a claw reaches; passing it counts.
        is_: Its state, as in a report.
    """

    robot: Name
    at: Name | None = None
    is_: RobotState | None = Field(default=None, alias="is")

    @model_validator(mode="after")
    def _said(self) -> Self:
        if self.at is None and self.is_ is None:
            raise ValueError("expected at: PLACE, is: STATE, or both")
        return self


class ItemCondition(Part):
    """An item lies, or is carried, as all of these say.

    Attributes:
        at: A place, dock or waypoint, nearer to it than a claw reaches; a carried item is where its robot is.
        carried: Whether a robot holds it.
        carried_by: Which robot holds it.
    """

    item: Name
    at: Name | None = None
    carried: bool | None = None
    carried_by: Name | None = None

    @model_validator(mode="after")
    def _said(self) -> Self:
        if self.at is None and self.carried is None and self.carried_by is None:
            raise ValueError("expected at: PLACE, carried: true or false, or carried_by: ROBOT")
        return self


class BatteryCondition(Part):
    """A robot's battery is below or above a share of its capacity."""

    battery: Name
    below: Share | None = None
    above: Share | None = None

    @model_validator(mode="after")
    def _one(self) -> Self:
        if (self.below is None) is (self.above is None):
            raise ValueError("expected either below: SHARE or above: SHARE")
        return self


class DoorCondition(Part):
    """A door is in a state."""

    door: Name
    is_: DoorState = Field(alias="is")


class OrderCondition(Part):
    """An order is in a state; a late one may be waiting, carried or delivered, too."""

    order: Name
    is_: OrderState = Field(alias="is")


class FaultCondition(Part):
    """A fault of this kind is active; of a robot, or of anything if none is named."""

    fault: Name
    robot: Name | None = None


def _pair(value: Any) -> Any:
    if isinstance(value, (list, tuple)) and len(value) != 2:  # noqa: PLR2004 - from and to
        raise ValueError(f"expected the two waypoints where the lane begins and ends, got {len(value)}")
    return value


class LaneCondition(Part):
    """A lane is closed or open, in the direction from the first waypoint to the second."""

    lane: Annotated[tuple[Name, Name], BeforeValidator(_pair)]
    is_: Literal["closed", "open"] = Field(alias="is")


class ItemsCondition(Part):
    """All items are where they are at the end of the run without faults: as near as a claw reaches, or carried."""

    items: Literal["as_without_faults"]


class AllOf(Part):
    """All of some conditions hold."""

    all: tuple[Condition, ...] = Field(min_length=1)


class AnyOf(Part):
    """At least one of some conditions holds."""

    any: tuple[Condition, ...] = Field(min_length=1)


class Not(Part):
    """A condition does not hold."""

    not_: Condition = Field(alias="not")


CONDITIONS: Final[Mapping[str, type[BaseModel]]] = MappingProxyType(
    {
        "all": AllOf,
        "any": AnyOf,
        "not": Not,
        "event": EventPattern,
        "goal": EventPattern,
        "item": ItemCondition,
        "items": ItemsCondition,
        "battery": BatteryCondition,
        "door": DoorCondition,
        "order": OrderCondition,
        "fault": FaultCondition,
        "lane": LaneCondition,
        "robot": RobotCondition,
    }
)
"""By the key that tells what a condition is; the first that a mapping has counts."""


def key_of(value: Any) -> str | None:
    """Return the key that tells what a condition is; None if it is none."""
    if isinstance(value, BaseModel):
        return next((key for key, kind in CONDITIONS.items() if type(value) is kind), None)
    return next((key for key in CONDITIONS if key in value), None) if isinstance(value, Mapping) else None


def _tag(value: Any) -> str | None:
    """Return the tag of a condition's model, which is no key of it, so that paths of errors are not mistaken."""
    key = key_of(value)
    return None if key is None else "<event>" if key == "goal" else f"<{key}>"


def _known(value: Any) -> Any:
    if key_of(value) is not None:
        return value
    if not isinstance(value, Mapping):
        raise ValueError(f"expected a condition such as {{robot: eve, at: lab}}, got {shown(value)}")  # noqa: TRY004 - of a file, not of a program
    alike = next((f"; did you mean {alike!r}?" for key in value if (alike := meant(str(key), CONDITIONS))), "")
    raise ValueError(f"is no condition{alike or f'; one has a key of {listed([*CONDITIONS][:3])}, {_rest()}'}")


def _rest() -> str:
    return ", ".join([*CONDITIONS][3:])


Condition = Annotated[
    Annotated[
        Annotated[AllOf, Tag("<all>")]
        | Annotated[AnyOf, Tag("<any>")]
        | Annotated[Not, Tag("<not>")]
        | Annotated[EventPattern, Tag("<event>")]
        | Annotated[ItemCondition, Tag("<item>")]
        | Annotated[ItemsCondition, Tag("<items>")]
        | Annotated[BatteryCondition, Tag("<battery>")]
        | Annotated[DoorCondition, Tag("<door>")]
        | Annotated[OrderCondition, Tag("<order>")]
        | Annotated[FaultCondition, Tag("<fault>")]
        | Annotated[LaneCondition, Tag("<lane>")]
        | Annotated[RobotCondition, Tag("<robot>")],
        Discriminator(_tag),
    ],
    BeforeValidator(_known),
]
"""What may hold at an instant: a state, or for an instant an event."""

AllOf.model_rebuild()
AnyOf.model_rebuild()
Not.model_rebuild()
