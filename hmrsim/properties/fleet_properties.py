"""Built-in properties of robots and orders: no deadlock, no empty battery, no late order."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.events.orders import OrderDelivered, OrderLate, OrderLost, OrderPlaced
from hmrsim.events.robots import (
    BatteryCritical,
    BatteryEmpty,
    BatteryEvent,
    BatteryFull,
    BatteryLow,
    BatteryRevived,
    ChargingBegan,
    ChargingEnded,
    Stopped,
)
from hmrsim.events.simulation import Deleted, Teleported
from hmrsim.events.traffic import Deadlock, MadeRoom, Rerouted, Waiting, WentOn
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.interfaces.simulation_interfaces import ResetSimulation
from hmrsim.properties.watcher import Obligation, Obligations, Watcher

if TYPE_CHECKING:
    from hmrsim.history.timeline import Timeline
    from hmrsim.properties.results import Ended, OnViolation, Verdict


class NoDeadlock(Watcher):
    """Robots do not wait for each other in a circle for longer than a limit in simulated seconds."""

    def __init__(self, limit: float, timeline: Timeline, on_violation: OnViolation) -> None:
        super().__init__("no_deadlock", on_violation)
        self._limit = limit
        self._circles: Obligations[tuple[str, ...]] = Obligations(timeline, limit, self._expired, keep=True)
        self._waits = 0
        timeline.on(Deadlock, self._begin)
        timeline.on(Waiting, self._wait)
        timeline.on((WentOn, Rerouted, MadeRoom, Stopped), self._go)
        timeline.on((Deleted, Teleported), self._move)
        # A reset of either scope halts all robots.
        timeline.on_reset(ResetSimulation.Request.SCOPE_STATE | ResetSimulation.Request.SCOPE_TIME, self._begin_anew)

    def _begin(self, at: int, event: Deadlock) -> None:
        circle = tuple(sorted(event.robots))
        if circle not in self._circles:
            self._circles.add(Obligation(at, circle))

    def _expired(self, at: int, obligation: Obligation[tuple[str, ...]]) -> None:
        *others, last = obligation.key
        names = f"{', '.join(others)} and {last}"
        self.violate(at, names, "deadlock", f"{names} wait for each other for more than {self._limit:g} s")

    def _wait(self, at: int, event: Waiting) -> None:
        self._waits += 1
        if self._circles:
            others = event.for_ or ()
            for circle in self._circles:
                if event.robot in circle and not any(other in circle for other in others):
                    self._circles.meet(at, circle)

    def _go(self, at: int, event: WentOn | Rerouted | MadeRoom | Stopped) -> None:
        if self._circles:
            self._leave(at, event.robot)

    def _move(self, at: int, event: Deleted | Teleported) -> None:
        self._leave(at, event.entity)

    def _leave(self, at: int, robot: str) -> None:
        for circle in self._circles:
            if robot in circle:
                self._circles.meet(at, circle)

    def _begin_anew(self, at: int) -> None:
        for circle in self._circles:
            self._circles.meet(at, circle)

    def end(self, at: int, _ended: Ended | None) -> None:
        """Count the circles that last to the end."""
        self._circles.end(at)

    def _unless_violated(self) -> Verdict:
        if not self._waits:
            return self._is("never_exercised", 1.0, "no robot waited on its way")
        seconds = self._circles.seconds
        text = f"the longest deadlock lasted {seconds:.1f} s" if seconds else "no robots waited for each other"
        if self._circles:
            return self._is("undecided", self._circles.least, f"{text}, up to the end")
        return self._is("holds", self._circles.least, text)


class NobodyStranded(Watcher):
    """No robot has an empty battery for longer than a limit in simulated seconds without being charged."""

    def __init__(self, limit: float, timeline: Timeline, on_violation: OnViolation, *, batteries: bool) -> None:
        super().__init__("nobody_stranded", on_violation)
        self._limit = limit
        self._batteries = batteries
        self._empty: dict[str, None] = {}
        self._stranded: Obligations[str] = Obligations(timeline, limit, self._expired, keep=True)
        self._lowest = 1.0
        timeline.on((BatteryLow, BatteryCritical, BatteryFull), self._look)
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
        self._stranded.meet(at, event.robot)

    def _stop_charging(self, at: int, event: ChargingEnded) -> None:
        self._look(at, event)
        if event.robot in self._empty:
            self._strand(at, event.robot)

    def _strand(self, at: int, robot: str) -> None:
        if robot not in self._stranded:
            self._stranded.add(Obligation(at, robot))

    def _forget(self, at: int, robot: str) -> None:
        self._empty.pop(robot, None)
        self._stranded.meet(at, robot)

    def _begin_anew(self, at: int) -> None:
        for robot in [*self._empty]:
            self._forget(at, robot)

    def _expired(self, at: int, obligation: Obligation[str]) -> None:
        robot = obligation.key
        text = f"the battery of {robot} is empty for more than {self._limit:g} s, and it is not charged"
        self.violate(at, robot, "stranded", text)

    def end(self, at: int, _ended: Ended | None) -> None:
        """Count the robots that are stranded at the end."""
        self._stranded.end(at)

    def _unless_violated(self) -> Verdict:
        """Return the verdict; half of its robustness is the lowest battery."""
        if not self._batteries:
            return self._is("never_exercised", 1.0, "no robot has a battery")
        if self._stranded:
            names = ", ".join(self._stranded)
            return self._is("undecided", 0.0, f"the battery of {names} was empty at the end")
        seconds = self._stranded.seconds
        if seconds:
            robustness = 0.5 - seconds / self._limit / 2
            return self._is("holds", robustness, f"the longest time of a robot was {seconds:.1f} s")
        low = f"the lowest reported charge of a battery was {self._lowest:.0%}"
        return self._is("holds", 0.5 + self._lowest / 2, low if self._lowest < 1.0 else "no battery was low")


class OrdersInTime(Watcher):
    """No order is late or lost."""

    def __init__(self, timeline: Timeline, on_violation: OnViolation) -> None:
        super().__init__("orders_in_time", on_violation)
        self._open: dict[str, tuple[int, float | None]] = {}
        self._placed = 0
        self._least = 1.0
        timeline.on(OrderPlaced, self._place)
        timeline.on(OrderDelivered, self._deliver)
        timeline.on(OrderLate, self._be_late)
        timeline.on(OrderLost, self._lose)
        # A reset of either scope ends all orders.
        ends = ResetSimulation.Request.SCOPE_STATE | ResetSimulation.Request.SCOPE_TIME
        timeline.on_reset(ends, lambda _at: self._open.clear())

    def _place(self, at: int, event: OrderPlaced) -> None:
        self._placed += 1
        self._open[event.order] = at, event.within

    def _deliver(self, at: int, event: OrderDelivered) -> None:
        self._spend(at, *self._open.pop(event.order, (at, None)))

    def _be_late(self, at: int, event: OrderLate) -> None:
        since, within = self._open.get(event.order, (at, None))
        after = f" after {within:g} s" if within is not None else f" since {since / NANOSECONDS:.1f} s"
        self.violate(at, event.order, "late", f"order {event.order} is late: {event.item} is not at {event.to}{after}")

    def _lose(self, at: int, event: OrderLost) -> None:
        self._open.pop(event.order, None)
        self.violate(at, event.order, "lost", f"order {event.order} is lost: {event.item} was deleted")

    def _spend(self, at: int, since: int, within: float | None) -> None:
        if within:
            self._least = min(self._least, 1.0 - (at - since) / NANOSECONDS / within)

    def end(self, at: int, _ended: Ended | None) -> None:
        """Count the orders that are open at the end."""
        for since, within in self._open.values():
            self._spend(at, since, within)

    def _unless_violated(self) -> Verdict:
        """Return the verdict; its robustness is the least share of time that an order had left."""
        if not self._placed:
            return self._is("never_exercised", 1.0, "no order came")
        if self._open:
            text = f"{len(self._open)} of {self._placed} orders were open at the end, and not late"
            return self._is("undecided", self._least, text)
        return self._is("holds", self._least, f"{self._placed} orders were delivered in time")
