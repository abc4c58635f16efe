"""The faults that are active."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.events.faults import FaultBegan, FaultEnded
from hmrsim.history.occurrence import SceneSeen, records
from hmrsim.properties.observing.signal import Signal

if TYPE_CHECKING:
    from hmrsim.history.timeline import Timeline


class Faults:
    """Follows the faults of a run."""

    def __init__(self, timeline: Timeline) -> None:
        self._active: dict[str, tuple[str, str]] = {}
        self._signals: dict[tuple[str, str | None], Signal] = {}
        timeline.on(FaultBegan, self._begin)
        timeline.on(FaultEnded, self._end)
        timeline.on(SceneSeen, self._see)

    def active(self, kind: str, robot: str | None) -> Signal:
        """Return whether a fault of a kind is active; of a robot, or any."""
        key = kind, robot
        if key not in self._signals:
            self._signals[key] = Signal()
            self._settle()
        return self._signals[key]

    def begin_anew(self) -> None:
        """Let no fault be active."""
        self._active.clear()
        self._settle()

    def _begin(self, _at: int, event: FaultBegan) -> None:
        self._active[event.name] = event.fault, event.robot
        self._settle()

    def _end(self, _at: int, event: FaultEnded) -> None:
        self._active.pop(event.name, None)
        self._settle()

    def _see(self, _at: int, scene: SceneSeen) -> None:
        self._active.clear()
        for said in records(scene.fields, "faults"):
            event = FaultBegan.from_json(said)
            self._active[event.name] = event.fault, event.robot
        self._settle()

    def _settle(self) -> None:
        active = [*self._active.values()]
        for (kind, robot), signal in self._signals.items():
            signal.say(holds=any(kind == fault and robot in (None, whose) for fault, whose in active))
