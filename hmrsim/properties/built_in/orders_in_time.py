"""No order is late or lost."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.events.orders import OrderDelivered, OrderLate, OrderLost, OrderPlaced
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.interfaces.simulation_interfaces import ResetSimulation
from hmrsim.properties.watcher import Watcher

if TYPE_CHECKING:
    from hmrsim.properties.observing.timeline import Timeline
    from hmrsim.properties.results import Ended, Tell, Verdict


class OrdersInTime(Watcher):
    """Knows the open orders, and how much of their time was left at most."""

    def __init__(self, timeline: Timeline, tell: Tell) -> None:
        super().__init__("orders_in_time", tell)
        self._open: dict[str, tuple[int, float | None]] = {}
        self._placed = 0
        self._least = 1.0
        timeline.on(OrderPlaced, self._place)
        timeline.on(OrderDelivered, self._deliver)
        timeline.on(OrderLate, self._be_late)
        timeline.on(OrderLost, self._lose)
        # Either one ends all orders.
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
        """Take note of the time that is left of orders that are open at the end."""
        for since, within in self._open.values():
            self._spend(at, since, within)

    def unless_violated(self) -> Verdict:
        """Return whether all orders were in time; the robustness is the least share of its time that one had left."""
        if not self._placed:
            return self._is("never_exercised", 1.0, "no order came")
        if self._open:
            said = f"{len(self._open)} of {self._placed} orders were open at the end, and not late"
            return self._is("undecided", self._least, said)
        return self._is("holds", self._least, f"{self._placed} orders were delivered in time")
