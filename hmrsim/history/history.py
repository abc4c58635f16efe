"""The state of a run and its faults; only the parts that a consumer reads are followed."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from hmrsim.events.faults import FaultBegan, FaultEnded
from hmrsim.history.facilities import Doors, Lanes
from hmrsim.history.items import Items, Orders
from hmrsim.history.occurrence import SceneSeen, records
from hmrsim.history.robots import Batteries, Robots
from hmrsim.history.timeline import Part
from hmrsim.interfaces.simulation_interfaces import ResetSimulation

if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Any

    from hmrsim.history.timeline import Timeline
    from hmrsim.world.model import World


@dataclass(slots=True)
class Fault:
    """A fault that has begun; times in nanoseconds.

    Attributes:
        fault: Its type.
        robot: The robot concerned; empty for a fault of another subject.
        ended: None while it is active.
    """

    name: str
    fault: str
    robot: str
    settings: Mapping[str, Any]
    began: int
    ended: int | None = None


class Faults(Part):
    """The faults of a run, watched by type.

    Attributes:
        all: All faults, in the order in which they began.
    """

    def __init__(self, timeline: Timeline) -> None:
        super().__init__()
        self.all: list[Fault] = []
        self.active: dict[str, Fault] = {}
        timeline.on(FaultBegan, self._begin)
        timeline.on(FaultEnded, self._end)
        timeline.on(SceneSeen, self._see)

    def of(self, robot: str) -> tuple[str, ...]:
        """Return the names of the active faults that may affect a robot: its own, and those without a robot."""
        return tuple(name for name, fault in self.active.items() if fault.robot in ("", robot))

    def is_active(self, kind: str, robot: str | None) -> bool:
        """Return whether a fault of a type is active, of a robot or of any."""
        return any(fault.fault == kind and robot in (None, fault.robot) for fault in self.active.values())

    def begin_anew(self) -> None:
        """Return to the initial state, in which no fault is active."""
        ended, self.active = self.active, {}
        for fault in ended.values():
            self.changed(fault.fault)

    def _begin(self, at: int, event: FaultBegan) -> None:
        fault = Fault(event.name, event.fault, event.robot, event.settings, at)
        self.all.append(fault)
        self.active[fault.name] = fault
        self.changed(fault.fault)

    def _end(self, at: int, event: FaultEnded) -> None:
        fault = self.active.pop(event.name, None)
        if fault is not None:
            fault.ended = at
            self.changed(fault.fault)

    def _see(self, at: int, scene: SceneSeen) -> None:
        self.begin_anew()
        for fault in records(scene.fields, "faults"):
            self._begin(at, FaultBegan.from_json(fault))


class History:
    """The state of a world after each occurrence of a timeline.

    A part subscribes to its events when it is first read, so read it before the run begins.
    """

    def __init__(self, timeline: Timeline, world: World) -> None:
        self._timeline, self._world = timeline, world
        timeline.on_reset(ResetSimulation.Request.SCOPE_STATE, self._begin_anew)

    @cached_property
    def robots(self) -> Robots:
        """The states of robots over time."""
        return Robots(self._timeline, self._world)

    @cached_property
    def batteries(self) -> Batteries:
        """The charge of batteries over time."""
        return Batteries(self._timeline, self._world)

    @cached_property
    def items(self) -> Items:
        """The locations of items over time."""
        return Items(self._timeline, self._world)

    @cached_property
    def doors(self) -> Doors:
        """The states of doors over time."""
        return Doors(self._timeline, self._world)

    @cached_property
    def lanes(self) -> Lanes:
        """The closed lanes over time."""
        return Lanes(self._timeline)

    @cached_property
    def orders(self) -> Orders:
        """The progress of orders over time."""
        return Orders(self._timeline)

    @cached_property
    def faults(self) -> Faults:
        """The active faults over time."""
        return Faults(self._timeline)

    def _begin_anew(self, _at: int) -> None:
        for part in [*vars(self).values()]:
            if isinstance(part, Part):
                part.begin_anew()
