"""The states of orders."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from hmrsim.events.orders import OrderDelivered, OrderLate, OrderLost, OrderPickedUp, OrderPlaced
from hmrsim.events.robots import ItemDropped, ItemPlaced
from hmrsim.properties.observing.signal import Signal

if TYPE_CHECKING:
    from hmrsim.history.timeline import Timeline

_LATE: Final = "late"
_OPEN: Final = ("waiting", "carried")


class Orders:
    """Follows the orders of a run."""

    def __init__(self, timeline: Timeline) -> None:
        self._states: dict[str, str] = {}
        self._late: dict[str, None] = {}
        self._items: dict[str, str] = {}
        self._signals: dict[str, dict[str, Signal]] = {}
        timeline.on(OrderPlaced, self._place)
        timeline.on(OrderPickedUp, lambda _at, event: self._change(event.order, "carried"))
        timeline.on(OrderDelivered, lambda _at, event: self._change(event.order, "delivered"))
        timeline.on(OrderLost, lambda _at, event: self._change(event.order, "lost"))
        timeline.on(OrderLate, self._be_late)
        for lies in (ItemPlaced, ItemDropped):
            timeline.on(lies, self._lie)

    def is_(self, order: str, state: str) -> Signal:
        """Return whether an order is in a state; a late one is in another one, too."""
        signals = self._signals.setdefault(order, {})
        if state not in signals:
            signals[state] = Signal()
            self._settle(order)
        return signals[state]

    def begin_anew(self) -> None:
        """Forget all orders."""
        known = [*self._states]
        for forgotten in (self._states, self._late, self._items):
            forgotten.clear()
        for order in known:
            self._settle(order)

    def _place(self, _at: int, event: OrderPlaced) -> None:
        self._items[event.item] = event.order
        self._change(event.order, "waiting")

    def _be_late(self, _at: int, event: OrderLate) -> None:
        self._late[event.order] = None
        self._settle(event.order)

    def _lie(self, _at: int, event: ItemPlaced | ItemDropped) -> None:
        order = self._items.get(event.item)
        if order is not None and self._states.get(order) in _OPEN:
            self._change(order, "waiting")

    def _change(self, order: str, state: str) -> None:
        self._states[order] = state
        self._settle(order)

    def _settle(self, order: str) -> None:
        for state, signal in self._signals.get(order, {}).items():
            signal.say(holds=order in self._late if state == _LATE else self._states.get(order) == state)
