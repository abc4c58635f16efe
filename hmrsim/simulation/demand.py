"""The demand of a world, which places orders, creates their items, and measures their progress.

An order is delivered when its item lies near its destination, no matter which robot brought it or how. Controllers do
not report deliveries. The item then leaves the world.
"""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Callable
from dataclasses import asdict, dataclass
from enum import StrEnum
from functools import partial
from typing import TYPE_CHECKING, Any, Final

from simpy import Timeout

from hmrsim.engine.environment import Tick
from hmrsim.engine.sim_time import stamp
from hmrsim.events.orders import OrderDelivered, OrderLate, OrderLost, OrderPickedUp, OrderPlaced
from hmrsim.events.robots import ItemEvent
from hmrsim.events.simulation import Deleted, Teleported
from hmrsim.geometry import METER, distance
from hmrsim.interfaces.builtin_interfaces import values_of
from hmrsim.protocol.outputs import EventStamped, OrdersChanged
from hmrsim.protocol.topics import Topic

if TYPE_CHECKING:
    from hmrsim.engine.chance import Chance
    from hmrsim.engine.environment import Alarm, Environment
    from hmrsim.engine.subscriptions import EventPublisher
    from hmrsim.simulation.entities import Roster
    from hmrsim.world.model import Demand as DemandSpec
    from hmrsim.world.model import World


class OrderState(StrEnum):
    """The progress of an order; the last two states are final."""

    WAITING = "waiting"
    CARRIED = "carried"
    DELIVERED = "delivered"
    LOST = "lost"

    @property
    def open(self) -> bool:
        """Return whether the order has yet to be served."""
        return self in {OrderState.WAITING, OrderState.CARRIED}


@dataclass(eq=False)
class Order:
    """An order. Times are in simulated seconds.

    Attributes:
        name: A name that is unique in the run.
        demand: The name of the demand that placed it; empty for an order of a client.
        item: The name of the item to bring.
        at: The place of the item when the order was placed.
        to: The place to bring it to.
        weight: The mass of the item, in kg.
        placed: The time at which it was placed.
        due: The deadline; None if there is none.
        robot: The robot that carries the item or has brought it; empty for none.
        picked_up: The time at which the item was first picked up; None if it was not.
        ended: The time at which it was delivered or lost; None while it is open.
        late: Whether it was not delivered by the deadline.
    """

    name: str
    demand: str
    item: str
    at: str
    to: str
    priority: int
    weight: float
    placed: float
    due: float | None
    robot: str = ""
    picked_up: float | None = None
    ended: float | None = None
    state: OrderState = OrderState.WAITING
    late: bool = False

    def as_dict(self) -> dict[str, Any]:
        """Return the order as JSON values."""
        times = {"placed": self.placed, "due": self.due, "picked_up": self.picked_up, "ended": self.ended}
        return {
            "name": self.name,
            "demand": self.demand,
            "item": self.item,
            "at": self.at,
            "to": self.to,
            "priority": self.priority,
            "weight": self.weight,
            "state": self.state.value,
            "robot": self.robot,
            "late": self.late,
            **{name: None if time is None else values_of(stamp(time)) for name, time in times.items()},
        }


@dataclass
class Totals:
    """The number of orders by outcome.

    Attributes:
        placed: All orders.
        delivered: Orders that were delivered, in time or late.
        late: Orders that were not delivered by their deadline, including those that were delivered later.
        lost: Orders whose item was deleted.
    """

    placed: int = 0
    delivered: int = 0
    late: int = 0
    lost: int = 0


NEAR: Final = METER
"""The distance to its destination within which an item counts as delivered, by the world's unit."""

_KEPT: Final = 1_000
"""The number of orders that are kept after they have ended."""


class Demand:
    """The orders of a run; a `Reaction` to the events of their items.

    Attributes:
        open: The orders that are still to be served, by name, in the order in which they were placed.
        closed: The last orders that have ended, in the order in which they ended.
        totals: The numbers of orders so far.
        lead_times: The seconds from placement to delivery of each delivered order.
    """

    topics = (Topic.EVENTS,)

    def __init__(self, env: Environment, roster: Roster, chance: Chance, publisher: EventPublisher) -> None:
        self._env = env
        self._roster = roster
        self._chance = chance
        self._publisher = publisher
        self.open: dict[str, Order] = {}
        self.closed: deque[Order] = deque(maxlen=_KEPT)
        self.totals = Totals()
        self.lead_times: list[float] = []
        self._world: World | None = None
        self._by_item: dict[str, Order] = {}
        self._moved: dict[str, None] = {}
        self._due: dict[str, Alarm] = {}
        self._coming: dict[str, Timeout] = {}
        self._held_back: dict[str, DemandSpec] = {}
        self._placed: defaultdict[str, int] = defaultdict(int)
        # The number of open orders of each demand.
        self._open_of: defaultdict[str, int] = defaultdict(int)
        self._numbers: defaultdict[str, int] = defaultdict(int)

    @property
    def served(self) -> bool:
        """Return whether all orders have ended and no further ones will come."""
        return not (self.open or self._coming or self._held_back)

    def has(self, item: str) -> bool:
        """Return whether an item belongs to an open order."""
        return item in self._by_item

    def as_dict(self) -> dict[str, Any]:
        """Return the open orders and the totals as JSON values."""
        return {
            "stamp": values_of(stamp(self._env.now)),
            "orders": [order.as_dict() for order in self.open.values()],
            "totals": asdict(self.totals),
        }

    def begin(self, world: World) -> None:
        """Start the orders of a world; earlier orders must have ended."""
        self._world = world
        for spec in world.demand:
            self._expect(spec)

    def end(self) -> None:
        """Forget all orders, and delete their items."""
        for coming in self._coming.values():
            self._env.abandon(coming)
        for alarm in self._due.values():
            self._env.cancel(alarm)
        for order in self.open.values():
            if order.item in self._roster.items:
                self._roster.delete(order.item)
        for known in (
            self.open,
            self._by_item,
            self._moved,
            self._due,
            self._coming,
            self._held_back,
            self._placed,
            self._open_of,
            self._numbers,
        ):
            known.clear()
        if self.totals.placed:
            self.closed.clear()
            self.lead_times.clear()
            self.totals = Totals()
            self._tell()

    def handler_for(self, kind: type) -> Callable[[Any], object] | None:
        """Return the function that processes outputs of a type; None to ignore them."""
        return self._note if kind is EventStamped else None

    def _note(self, stamped: EventStamped) -> None:
        """Record an event of an order's item; its consequences are published at the end of this instant.

        All sinks therefore receive the event before its consequences.
        """
        event = stamped.event
        item = event.item if isinstance(event, ItemEvent) else ""
        if isinstance(event, (Deleted, Teleported)):
            item = event.entity
        if item in self._by_item:
            if not self._moved:
                Tick(self._env, self._env.now).callbacks = [lambda _event: self._look()]
            self._moved[item] = None

    def place(self, spec: DemandSpec, *, by_client: bool = False) -> Order:
        """Place an order now, with the next number of its demand."""
        world = self._world
        if world is None:
            raise AssertionError
        number = self._placed[spec.name] = self._placed[spec.name] + 1
        at = spec.at[self._chance.choose(len(spec.at), spec.name, "at", number)]
        to = spec.to[self._chance.choose(len(spec.to), spec.name, "to", number)]
        within = None if spec.within is None else self._chance.drawn(spec.within, spec.name, "within", number)
        item = self._free_item(spec.item or spec.name)
        demand = "" if by_client else spec.name
        name = f"{spec.name}_{number}"
        now = self._env.now
        due = None if within is None else now + within
        order = Order(name, demand, item, at, to, spec.priority, spec.weight, now, due)
        self.open[order.name] = self._by_item[item] = order
        self._open_of[demand] += 1
        self.totals.placed += 1
        self._roster.spawn_item(item, spec.weight, world.point(at))
        self._publisher.publish(
            lambda: OrderPlaced(order.name, item, at, to, spec.priority, within, spec.weight, demand)
        )
        if within is not None:
            self._due[order.name] = self._env.alarm(within, partial(self._be_late, order))
        self._tell()
        return order

    def _free_item(self, kind: str) -> str:
        """Return an unused name for an item."""
        while True:
            self._numbers[kind] += 1
            name = f"{kind}_{self._numbers[kind]}"
            if self._roster.find(name) is None:
                return name

    def _expect(self, spec: DemandSpec) -> None:
        """Schedule the next order of a demand, if there will be one and not too many are open."""
        number = self._placed[spec.name] + 1
        if spec.count is not None and number > spec.count:
            return
        if self._open_of[spec.name] >= spec.most_open:
            self._held_back[spec.name] = spec
            return
        first = number == 1 and spec.first is not None
        value, use = (spec.first, "first") if first and spec.first is not None else (spec.arrives, "arrives")
        seconds = self._chance.drawn(value, spec.name, use, number)
        if spec.until is not None and self._env.now + seconds > spec.until:
            return
        coming = self._coming[spec.name] = Timeout(self._env, seconds)
        coming.callbacks = [lambda _event: self._come(spec)]

    def _come(self, spec: DemandSpec) -> None:
        del self._coming[spec.name]
        self.place(spec)
        self._expect(spec)

    def _be_late(self, order: Order) -> None:
        del self._due[order.name]
        order.late = True
        self.totals.late += 1
        self._publisher.publish(lambda: OrderLate(order.name, order.item, order.to))
        self._tell()

    def _look(self) -> None:
        """Find where the items are that were handled at this instant."""
        moved, self._moved = self._moved, {}
        for item in moved:
            order = self._by_item.get(item)
            if order is not None:
                self._look_at(order)

    def _look_at(self, order: Order) -> None:
        item, world = self._roster.items.get(order.item), self._world
        if item is None or world is None:
            self._close(order, OrderState.LOST, lambda: OrderLost(order.name, order.item))
        elif item.carrier is not None:
            carrier = item.carrier.name
            if (order.state, order.robot) == (OrderState.CARRIED, carrier):
                return
            order.state, order.robot = OrderState.CARRIED, carrier
            order.picked_up = self._env.now if order.picked_up is None else order.picked_up
            self._publisher.publish(lambda: OrderPickedUp(order.name, order.item, carrier))
            self._tell()
        elif distance(item.point, world.point(order.to)) <= NEAR[world.units]:
            lead = self._env.now - order.placed
            late = max(0.0, self._env.now - order.due) if order.due is not None else 0.0
            self.totals.delivered += 1
            self.lead_times.append(lead)
            self._close(
                order,
                OrderState.DELIVERED,
                lambda: OrderDelivered(order.name, order.item, lead, late, order.robot),
            )
            self._roster.delete(order.item)
        else:
            order.state, order.robot = OrderState.WAITING, ""
            self._tell()

    def _close(self, order: Order, state: OrderState, event: Callable[[], OrderDelivered | OrderLost]) -> None:
        order.state, order.ended = state, self._env.now
        if state is OrderState.LOST:
            self.totals.lost += 1
        del self.open[order.name], self._by_item[order.item]
        self._open_of[order.demand] -= 1
        self.closed.append(order)
        if order.name in self._due:
            self._env.cancel(self._due.pop(order.name))
        self._publisher.publish(event)
        self._tell()
        if order.demand in self._held_back:
            self._expect(self._held_back.pop(order.demand))

    def _tell(self) -> None:
        self._publisher.emit(OrdersChanged())
