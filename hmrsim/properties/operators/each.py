"""A property about each robot on its own."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Final

from hmrsim.events.simulation import Spawned
from hmrsim.properties.results import Verdict
from hmrsim.properties.watcher import Watcher

if TYPE_CHECKING:
    from hmrsim.properties.observing.timeline import Timeline
    from hmrsim.properties.results import Ended, State, Tell

_WORST_FIRST: Final[tuple[State, ...]] = ("violated", "undecided", "holds", "never_exercised")


class Each(Watcher):
    """Watches over the same property for each robot, those that come later included.

    Args:
        make: Makes what watches over it for a robot.
        all_count: Whether it is exercised only if it is so for each robot.
    """

    def __init__(
        self,
        name: str,
        robots: Iterable[str],
        make: Callable[[str], Watcher],
        timeline: Timeline,
        tell: Tell,
        *,
        all_count: bool = False,
    ) -> None:
        super().__init__(name, tell)
        self._make = make
        self._all_count = all_count
        self._watchers = {robot: make(robot) for robot in robots}
        timeline.on(Spawned, self._spawn)

    def _spawn(self, at: int, event: Spawned) -> None:
        if event.type != "item" and event.entity not in self._watchers:
            self._watchers[event.entity] = self._make(event.entity)
            self._watchers[event.entity].begin(at)

    def begin(self, at: int) -> None:
        """Begin for all robots."""
        for watcher in self._watchers.values():
            watcher.begin(at)

    def end(self, at: int, ended: Ended | None) -> None:
        """End for all robots."""
        for watcher in self._watchers.values():
            watcher.end(at, ended)

    def verdict(self) -> Verdict:
        """Return the worst verdict of all robots."""
        verdicts = [(robot, watcher.verdict()) for robot, watcher in self._watchers.items()]
        order = [*_WORST_FIRST]
        if self._all_count:
            order = ["violated", "undecided", "never_exercised", "holds"]
        if not verdicts:
            return self._is("never_exercised", 1.0, "there is no robot that it is about")
        robot, worst = min(verdicts, key=lambda each: (order.index(each[1].state), each[1].robustness))
        same = sum(verdict.state == worst.state for _, verdict in verdicts)
        more = f" (and {same - 1} more robots)" if same > 1 else ""
        robustness = min(verdict.robustness for _, verdict in verdicts)
        return Verdict(self.name, worst.state, robustness, f"{robot}: {worst.text}{more}")
