"""Robots do not wait for each other in a circle for longer than a limit."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.events.robots import Stopped
from hmrsim.events.simulation import Deleted, Teleported
from hmrsim.events.traffic import Deadlock, MadeRoom, Rerouted, Waiting, WentOn
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.interfaces.simulation_interfaces import ResetSimulation
from hmrsim.properties.observing.timeline import Phase
from hmrsim.properties.watcher import Watcher

if TYPE_CHECKING:
    from hmrsim.properties.observing.timeline import Alarm, Timeline
    from hmrsim.properties.results import Ended, Tell, Verdict


class NoDeadlock(Watcher):
    """Knows the circles in which robots wait, and since when.

    Args:
        limit: Simulated seconds for which a circle may last.
    """

    def __init__(self, limit: float, timeline: Timeline, tell: Tell) -> None:
        super().__init__("no_deadlock", tell)
        self._limit = limit
        self._timeline = timeline
        self._circles: dict[tuple[str, ...], tuple[int, Alarm]] = {}
        self._longest = 0
        self._waits = 0
        timeline.on(Deadlock, self._begin)
        timeline.on(Waiting, self._wait)
        for kind in (WentOn, Rerouted, MadeRoom, Stopped):
            timeline.on(kind, self._go)
        for moved in (Deleted, Teleported):
            timeline.on(moved, self._move)
        # Either one halts all robots.
        timeline.on_reset(ResetSimulation.Request.SCOPE_STATE | ResetSimulation.Request.SCOPE_TIME, self._begin_anew)

    def _begin(self, at: int, event: Deadlock) -> None:
        circle = tuple(sorted(event.robots))
        if circle not in self._circles:
            due = at + round(self._limit * NANOSECONDS)
            alarm = self._timeline.alarm(due, Phase.EXPIRY, lambda now: self._over(now, circle))
            self._circles[circle] = at, alarm

    def _over(self, at: int, circle: tuple[str, ...]) -> None:
        self._longest = round(self._limit * NANOSECONDS)
        names = f"{', '.join(circle[:-1])} and {circle[-1]}"
        self.violate(at, names, "deadlock", f"{names} wait for each other for more than {self._limit:g} s")

    def _wait(self, at: int, event: Waiting) -> None:
        self._waits += 1
        if self._circles:
            others = event.for_ or ()
            for circle in [*self._circles]:
                if event.robot in circle and not any(other in circle for other in others):
                    self._dissolve(at, circle)

    def _go(self, at: int, event: WentOn | Rerouted | MadeRoom | Stopped) -> None:
        if self._circles:
            self._leave(at, event.robot)

    def _move(self, at: int, event: Deleted | Teleported) -> None:
        self._leave(at, event.entity)

    def _leave(self, at: int, robot: str) -> None:
        for circle in [*self._circles]:
            if robot in circle:
                self._dissolve(at, circle)

    def _dissolve(self, at: int, circle: tuple[str, ...]) -> None:
        since, alarm = self._circles.pop(circle)
        alarm.cancel()
        self._longest = max(self._longest, at - since)

    def _begin_anew(self, at: int) -> None:
        for circle in [*self._circles]:
            self._dissolve(at, circle)

    def end(self, at: int, _ended: Ended | None) -> None:
        """Take note of how long circles have lasted that are there at the end."""
        for since, _ in self._circles.values():
            self._longest = max(self._longest, at - since)

    def unless_violated(self) -> Verdict:
        """Return whether no circle has lasted for too long."""
        if not self._waits:
            return self._is("never_exercised", 1.0, "no robot waited on its way")
        seconds = self._longest / NANOSECONDS
        said = f"the longest deadlock lasted {seconds:.1f} s" if seconds else "no robots waited for each other"
        if self._circles:
            return self._is("undecided", 1.0 - seconds / self._limit, f"{said}, up to the end")
        return self._is("holds", 1.0 - seconds / self._limit, said)
