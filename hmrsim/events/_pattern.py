"""Patterns of events: a kind with values of its fields, or a change of a goal.

Faults begin at events that match a pattern, and properties of runs refer to them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from hmrsim.diagnostics import Finding, instead
from hmrsim.events._registry import registry
from hmrsim.events.goals import GoalStatusChanged, SendGoalRejected

if TYPE_CHECKING:
    from hmrsim.events._event import Event

GoalChange = Literal["accepted", "executing", "canceling", "succeeded", "canceled", "aborted", "ended", "rejected"]

STATUSES: Final[Mapping[str, frozenset[int]]] = MappingProxyType(
    {
        "accepted": frozenset({1}),
        "executing": frozenset({2}),
        "canceling": frozenset({3}),
        "succeeded": frozenset({4}),
        "canceled": frozenset({5}),
        "aborted": frozenset({6}),
        "ended": frozenset({4, 5, 6}),
        "rejected": frozenset(),
    }
)
"""The numbers of action_msgs/msg/GoalStatus for each change of a goal; a rejected goal has no status."""

_STATUS: Final = GoalStatusChanged.kind
_REJECTED: Final = SendGoalRejected.kind


class EventPattern(BaseModel):
    """A pattern of events: either an *event* or a *goal*.

    Attributes:
        event: A kind of event, such as ``picked``.
        where: Values of its fields, as in its JSON; all must be equal.
        goal: A change of a goal: a status in lower case, ``ended`` for any terminal status, or ``rejected``.
        action: The action of that goal, or None for any.
        robot: The robot of the event or goal, or None for any.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    event: str | None = Field(default=None, description="A kind of event, such as `picked`.")
    where: dict[str, Any] = Field(default={}, description="Values of the event's fields; all must be equal.")
    goal: GoalChange | None = Field(
        default=None, description="A change of a goal; `ended` stands for succeeded, canceled and aborted."
    )
    action: str | None = Field(default=None, description="The goal's action; omitted for any.")
    robot: str | None = Field(default=None, description="The robot of the event or goal; omitted for any.")

    @model_validator(mode="after")
    def _one(self) -> Self:
        if (self.event is None) is (self.goal is None):
            raise ValueError("expected either event: KIND or goal: STATUS")
        if self.goal is None and self.action is not None:
            raise ValueError("action belongs to goal; for an event say where: {action: …}")
        if self.goal is not None and self.where:
            raise ValueError("where belongs to event; for a goal say robot and action")
        return self

    @property
    def kind(self) -> str:
        """The kind of event that can match."""
        if self.goal is None:
            return self.event or ""
        return _REJECTED if self.goal == _REJECTED else _STATUS

    def matches(self, event: Event) -> bool:
        """Return whether an event matches."""
        kind = event.kind
        if self.goal is None:
            return kind == self.event and self._fits(event)
        if kind == _STATUS:
            return self.matches_goal(event.robot, event.action, event.status)  # type: ignore[attr-defined]  # by its kind
        return kind == self.goal == _REJECTED and self._is_of(event.robot, event.action)  # type: ignore[attr-defined]

    def matches_goal(self, robot: str, action: str, status: int) -> bool:
        """Return whether a change of a goal to a status matches."""
        return self.goal is not None and status in STATUSES[self.goal] and self._is_of(robot, action)

    def flaws(self) -> Iterator[Finding]:
        """Yield the errors that don't depend on the world: unknown kinds and fields."""
        if self.event is None:
            return
        kind = registry().get(self.event)
        if kind is None:
            message = f"there is no kind of event {self.event!r}{instead(self.event, registry())}"
            yield Finding(("event",), message, self.event)
            return
        if kind.rest:
            return
        fields = [field.rstrip("_") for field in kind._fields]
        for name in self.where:
            if name not in fields:
                yield Finding(("where", name), f"{self.event} has no field {name!r}{instead(name, fields)}", name)
        if self.robot is not None and "robot" not in fields:
            yield Finding(("robot",), f"{self.event} is not about a robot", self.robot)

    def describe(self) -> str:
        """Return the pattern in words, such as ``pickup of eve is accepted``."""
        if self.goal is not None:
            whose = f" of {self.robot}" if self.robot else ""
            return f"{self.action or 'a goal'}{whose} is {self.goal}"
        values = {**({"robot": self.robot} if self.robot else {}), **self.where}
        fields = ", ".join(f"{name} {value}" for name, value in values.items())
        return f"{self.event}{f' ({fields})' if fields else ''}"

    def _is_of(self, robot: str, action: str) -> bool:
        return self.robot in (None, robot) and self.action in (None, action)

    def _fits(self, event: Event) -> bool:
        if self.robot is not None and getattr(event, "robot", None) != self.robot:
            return False
        if not self.where:
            return True
        fields = event.to_json()
        return all(name in fields and fields[name] == value for name, value in self.where.items())
