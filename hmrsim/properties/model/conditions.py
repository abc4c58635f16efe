"""Conditions on an instant of a run. A field named ``robot`` may be ``*``, for each robot."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal, Self

from pydantic import BaseModel, BeforeValidator, Field, model_validator

from hmrsim.diagnostics import listed
from hmrsim.events import EventPattern
from hmrsim.properties.model.part import EACH, Name, Part, one_of

RobotState = Literal["idle", "busy", "driving", "waiting", "charging", "stopped", "offline"]
"""The states of a robot, as reports name them."""

DoorState = Literal["open", "closed", "opening", "jammed"]
OrderState = Literal["waiting", "carried", "delivered", "lost", "late"]

Share = Annotated[float, Field(strict=True, ge=0, le=1)]


def _robot(name: str) -> str:
    return "each robot" if name == EACH else name


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
    def _says_something(self) -> Self:
        if self.at is None and self.is_ is None:
            raise ValueError("expected at: PLACE, is: STATE, or both")
        return self

    def describe(self) -> str:
        """Return the condition in words."""
        states = [f"at {self.at}"] if self.at else []
        return f"{_robot(self.robot)} is {' and '.join([*states, *([self.is_] if self.is_ else [])])}"


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
    def _says_something(self) -> Self:
        if self.at is None and self.carried is None and self.carried_by is None:
            raise ValueError("expected at: PLACE, carried: true or false, or carried_by: ROBOT")
        return self

    def describe(self) -> str:
        """Return the condition in words."""
        states = [f"is at {self.at}"] if self.at else []
        if self.carried_by is not None:
            states.append(f"is carried by {_robot(self.carried_by)}")
        elif self.carried is not None:
            states.append("is carried" if self.carried else "is not carried")
        return f"{self.item} {' and '.join(states)}"


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

    def describe(self) -> str:
        """Return the condition in words."""
        limit = f"above {self.above:.0%}" if self.above is not None else f"below {self.below:.0%}"
        return f"the battery of {_robot(self.battery)} is {limit}"


class DoorCondition(Part):
    """A door is in a state."""

    door: Name
    is_: DoorState = Field(alias="is")

    def describe(self) -> str:
        """Return the condition in words."""
        return f"door {self.door} is {self.is_}"


class OrderCondition(Part):
    """An order is in a state; a late one may be waiting, carried or delivered, too."""

    order: Name
    is_: OrderState = Field(alias="is")

    def describe(self) -> str:
        """Return the condition in words."""
        return f"order {self.order} is {self.is_}"


class FaultCondition(Part):
    """A fault of this kind is active; of a robot, or of anything if none is named."""

    fault: Name
    robot: Name | None = None

    def describe(self) -> str:
        """Return the condition in words."""
        return f"{_robot(self.robot)} has a fault {self.fault}" if self.robot else f"there is a fault {self.fault}"


def _pair(value: Any) -> Any:
    if isinstance(value, (list, tuple)) and len(value) != 2:  # noqa: PLR2004 - from and to
        raise ValueError(f"expected the two waypoints where the lane begins and ends, got {len(value)}")
    return value


class LaneCondition(Part):
    """A lane is closed or open, in the direction from the first waypoint to the second."""

    lane: Annotated[tuple[Name, Name], BeforeValidator(_pair)]
    is_: Literal["closed", "open"] = Field(alias="is")

    def describe(self) -> str:
        """Return the condition in words."""
        return f"lane {'-'.join(self.lane)} is {self.is_}"


class ItemsCondition(Part):
    """All items are where they are at the end of the run without faults, within a claw's reach, or carried as there."""

    items: Literal["as_without_faults"]

    def describe(self) -> str:
        """Return the condition in words."""
        return "all items are where they are without faults"


class AllOf(Part):
    """All of some conditions hold."""

    all: tuple[Condition, ...] = Field(min_length=1)

    def describe(self) -> str:
        """Return the condition in words."""
        return " and ".join(map(_operand, self.all))


class AnyOf(Part):
    """At least one of some conditions holds."""

    any: tuple[Condition, ...] = Field(min_length=1)

    def describe(self) -> str:
        """Return the condition in words."""
        return " or ".join(map(_operand, self.any))


class Not(Part):
    """A condition does not hold."""

    not_: Condition = Field(alias="not")

    def describe(self) -> str:
        """Return the condition in words."""
        return f"not {_operand(self.not_)}"


def _operand(condition: Condition) -> str:
    text = condition.describe()
    return f"({text})" if isinstance(condition, (AllOf, AnyOf)) else text


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


if TYPE_CHECKING:
    Condition = (
        AllOf
        | AnyOf
        | Not
        | EventPattern
        | ItemCondition
        | ItemsCondition
        | BatteryCondition
        | DoorCondition
        | OrderCondition
        | FaultCondition
        | LaneCondition
        | RobotCondition
    )
else:
    _keys = f"has a key of {listed([*CONDITIONS][:3])}, {', '.join([*CONDITIONS][3:])}"
    Condition = one_of(CONDITIONS, "condition", "a condition such as {robot: eve, at: lab}", _keys)
"""What may hold at an instant: a state, or for an instant an event."""

AllOf.model_rebuild()
AnyOf.model_rebuild()
Not.model_rebuild()
