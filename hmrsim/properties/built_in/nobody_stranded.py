"""No robot has an empty battery for longer than a limit without being charged."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.events.robots import (
    BatteryCritical,
    BatteryEmpty,
    BatteryEvent,
    BatteryFull,
    BatteryLow,
    BatteryRevived,
    ChargingBegan,
    ChargingEnded,
)
from hmrsim.events.simulation import Deleted
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.interfaces.simulation_interfaces import ResetSimulation
from hmrsim.properties.observing.timeline import Phase
from hmrsim.properties.watcher import Watcher

if TYPE_CHECKING:
    from hmrsim.properties.observing.timeline import Alarm, Timeline
    from hmrsim.properties.results import Ended, Tell, Verdict


class NobodyStranded(Watcher):
    """Knows the robots with an empty battery, and since when they are not charged.

    Args:
        limit: Simulated seconds for which a robot may be stranded.
    """

    def __init__(self, limit: float, timeline: Timeline, tell: Tell, *, batteries: bool) -> None:
        super().__init__("nobody_stranded", tell)
        self._limit = limit
        self._timeline = timeline
        self._batteries = batteries
        self._empty: dict[str, None] = {}
        self._stranded: dict[str, tuple[int, Alarm]] = {}
        self._longest = 0
        self._lowest = 1.0
        for kind in (BatteryLow, BatteryCritical, BatteryFull):
            timeline.on(kind, self._look)
        timeline.on(BatteryEmpty, self._run_out)
        timeline.on(BatteryRevived, self._revive)
        timeline.on(ChargingBegan, self._charge)
        timeline.on(ChargingEnded, self._stop_charging)
        timeline.on(Deleted, lambda at, event: self._forget(at, event.entity))
        # Nothing else fills batteries.
        timeline.on_reset(ResetSimulation.Request.SCOPE_STATE, self._begin_anew)

    def _look(self, _at: int, event: BatteryEvent) -> None:
        self._batteries = True
        self._lowest = min(self._lowest, event.percentage)

    def _run_out(self, at: int, event: BatteryEmpty) -> None:
        self._look(at, event)
        self._empty[event.robot] = None
        self._strand(at, event.robot)

    def _revive(self, at: int, event: BatteryRevived) -> None:
        self._forget(at, event.robot)

    def _charge(self, at: int, event: ChargingBegan) -> None:
        self._look(at, event)
        self._save(at, event.robot)

    def _stop_charging(self, at: int, event: ChargingEnded) -> None:
        self._look(at, event)
        if event.robot in self._empty:
            self._strand(at, event.robot)

    def _strand(self, at: int, robot: str) -> None:
        if robot not in self._stranded:
            due = at + round(self._limit * NANOSECONDS)
            alarm = self._timeline.alarm(due, Phase.EXPIRY, lambda now: self._over(now, robot))
            self._stranded[robot] = at, alarm

    def _save(self, at: int, robot: str) -> None:
        if robot in self._stranded:
            since, alarm = self._stranded.pop(robot)
            alarm.cancel()
            self._longest = max(self._longest, at - since)

    def _forget(self, at: int, robot: str) -> None:
        self._empty.pop(robot, None)
        self._save(at, robot)

    def _begin_anew(self, at: int) -> None:
        for robot in [*self._empty]:
            self._forget(at, robot)

    def _over(self, at: int, robot: str) -> None:
        text = f"the battery of {robot} is empty for more than {self._limit:g} s, and it is not charged"
        self.violate(at, robot, "stranded", text)

    def end(self, at: int, _ended: Ended | None) -> None:
        """Take note of how long robots have been stranded that are so at the end."""
        for since, _ in self._stranded.values():
            self._longest = max(self._longest, at - since)

    def unless_violated(self) -> Verdict:
        """Return whether nobody was stranded for too long; half of the robustness is the lowest battery."""
        if not self._batteries:
            return self._is("never_exercised", 1.0, "no robot has a battery")
        seconds = self._longest / NANOSECONDS
        if self._stranded:
            names = ", ".join(self._stranded)
            return self._is("undecided", 0.0, f"the battery of {names} was empty at the end")
        if self._longest:
            return self._is(
                "holds", 0.5 - seconds / self._limit / 2, f"the longest time of a robot was {seconds:.1f} s"
            )
        low = f"the lowest battery that was told of was at {self._lowest:.0%}"
        return self._is("holds", 0.5 + self._lowest / 2, low if self._lowest < 1.0 else "no battery was low")
