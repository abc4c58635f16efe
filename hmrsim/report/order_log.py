"""The orders of the demand and what became of them; times in nanoseconds."""

from __future__ import annotations

from dataclasses import dataclass, field

from hmrsim.events.orders import OrderDelivered, OrderLate, OrderLost, OrderPickedUp, OrderPlaced
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS


@dataclass(slots=True)
class OrderRecord:
    """The account of one order.

    Attributes:
        due: When it is late; None for never.
        picked_up: When a robot took its item the first time; None if none did.
        ended: When it was delivered or lost; None if it was neither.
        robot: Who has brought it, or carries it.
    """

    name: str
    item: str
    at: str
    to: str
    priority: int
    placed: int
    due: int | None
    picked_up: int | None = None
    ended: int | None = None
    robot: str = ""
    state: str = "waiting"
    late: bool = False


@dataclass(slots=True)
class OrderLog:
    """The orders of a run, in the order in which they came."""

    all: list[OrderRecord] = field(default_factory=list)
    _open: dict[str, OrderRecord] = field(default_factory=dict)

    def take(self, at: int, event: object) -> None:
        """Record an event, if it concerns an order."""
        match event:
            case OrderPlaced(order, item, from_, to, priority, within):
                due = None if within is None else at + round(within * NANOSECONDS)
                record = OrderRecord(order, item, from_, to, priority, at, due)
                self.all.append(record)
                self._open[order] = record
            case OrderPickedUp() | OrderDelivered() | OrderLate() | OrderLost() if event.order in self._open:
                self._change(at, self._open[event.order], event)

    def begin_anew(self) -> None:
        """Record that simulated time begins anew: what was open stays so for ever."""
        self._open.clear()

    def _change(
        self, at: int, record: OrderRecord, event: OrderPickedUp | OrderDelivered | OrderLate | OrderLost
    ) -> None:
        match event:
            case OrderPickedUp(robot=robot):
                record.robot, record.state = robot, "carried"
                record.picked_up = at if record.picked_up is None else record.picked_up
            case OrderDelivered(robot=robot):
                record.robot, record.state, record.ended = robot, "delivered", at
            case OrderLost():
                record.state, record.ended = "lost", at
            case OrderLate():
                record.late = True
        if record.ended is not None:
            del self._open[record.name]
