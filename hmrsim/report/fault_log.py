"""The injected faults of a run, with their times and robots."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hmrsim.events.faults import FaultBegan
    from hmrsim.report.track import Track


@dataclass(slots=True)
class FaultRecord:
    """A fault that has begun; *robot* is empty for a fault of another subject."""

    name: str
    fault: str
    robot: str
    settings: Mapping[str, Any]
    began: int
    ended: int | None = None


@dataclass(slots=True)
class FaultLog:
    """All faults, in order, and the active ones."""

    all: list[FaultRecord] = field(default_factory=list)
    going_on: dict[str, FaultRecord] = field(default_factory=dict)

    def begin(self, at: int, event: FaultBegan) -> FaultRecord:
        """Record that a fault has begun, and return it."""
        fault = FaultRecord(event.name, event.fault, event.robot, event.settings, at)
        self.all.append(fault)
        self.going_on[fault.name] = fault
        return fault

    def end(self, at: int, name: str) -> FaultRecord | None:
        """Record that a fault has ended, and return it if it was known."""
        fault = self.going_on.pop(name, None)
        if fault is not None:
            fault.ended = at
        return fault

    def at(self, robot: str) -> tuple[str, ...]:
        """Return the names of the active faults that may affect a robot: its own, and those without a robot."""
        return tuple(name for name, fault in self.going_on.items() if fault.robot in ("", robot))


def hit(fault: FaultRecord, track: Track, *, begins: bool) -> None:
    """Record the effect of a fault on the state of its robot."""
    hurt = {"breakdown": track.disabled_reasons, "messages_lost": track.cut_off}.get(fault.fault)
    if hurt is not None:
        (hurt.add if begins else hurt.discard)(fault.name)
