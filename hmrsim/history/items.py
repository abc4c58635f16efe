"""The items of a run, with their locations and carriers, and the orders of the demand."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from hmrsim.events.orders import OrderDelivered, OrderEvent, OrderLate, OrderLost, OrderPickedUp, OrderPlaced
from hmrsim.events.robots import ItemDropped, ItemPicked, ItemPlaced
from hmrsim.events.simulation import Deleted, Spawned, Teleported
from hmrsim.history.occurrence import SceneSeen, point, records, text
from hmrsim.history.timeline import Part
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS

if TYPE_CHECKING:
    from collections.abc import Iterator

    from hmrsim.geometry import Point
    from hmrsim.history.timeline import Timeline
    from hmrsim.world.model import World


@dataclass(slots=True)
class Item:
    """An item's location or carrier.

    Attributes:
        at: The point where it lies; None while it is carried or does not exist, except that a scene gives a
            point for carried items, too.
        carrier: The robot that carries it; empty for none.
    """

    at: Point | None = None
    carrier: str = ""


class Items(Part):
    """The items of a run, watched by name."""

    def __init__(self, timeline: Timeline, world: World) -> None:
        super().__init__()
        self._world = world
        self._items: dict[str, Item] = {}
        self.begin_anew()
        timeline.on(ItemPicked, lambda _at, event: self._set(event.item, None, event.robot))
        timeline.on((ItemPlaced, ItemDropped), lambda _at, event: self._set(event.item, event.at))
        timeline.on((Teleported, Spawned), self._put)
        timeline.on(Deleted, self._delete)
        timeline.on(SceneSeen, self._see)

    def __getitem__(self, name: str) -> Item:
        """Return an item, which may not exist yet."""
        return self._items.setdefault(name, Item())

    def present(self) -> Iterator[tuple[str, Item]]:
        """Yield the items that exist, with their names."""
        return ((name, item) for name, item in self._items.items() if item.at is not None or item.carrier)

    def begin_anew(self) -> None:
        """Return all items to their initial places."""
        for name in [*self._items]:
            if name not in self._world.items:
                self._set(name, None)
        for name, item in self._world.items.items():
            self._set(name, self._world.point(item.at))

    def _set(self, name: str, at: Point | None, carrier: str = "") -> None:
        item = self[name]
        item.at, item.carrier = at, carrier
        self.changed(name)

    def _put(self, _at: int, event: Teleported | Spawned) -> None:
        if event.entity in self._items or (isinstance(event, Spawned) and event.type == "item"):
            self._set(event.entity, event.at)

    def _delete(self, _at: int, event: Deleted) -> None:
        if event.entity in self._items:
            self._set(event.entity, None)

    def _see(self, _at: int, scene: SceneSeen) -> None:
        seen = {text(item, "name"): item for item in records(scene.fields, "items")}
        for name in dict.fromkeys([*self._items, *seen]):
            if name not in seen:
                self._set(name, None)
            else:
                carried = seen[name].get("carrier") is not None
                self._set(name, point(seen[name], "at"), text(seen[name], "carrier") if carried else "")


@dataclass(slots=True)
class Order:
    """An order and its progress; times in nanoseconds.

    Attributes:
        at: The place of the item.
        to: The destination.
        due: When it is late; None for never.
        picked_up: When a robot picked up the item for the first time; None if none did.
        ended: When it was delivered or lost; None while it is open.
        robot: The robot that delivered the item, or carries it.
        state: The name of the state, as in ``_world/scene``.
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


class Orders(Part):
    """The orders of a run, watched by name.

    Attributes:
        all: All orders whose beginning is known, in the order in which they were placed.
    """

    def __init__(self, timeline: Timeline) -> None:
        super().__init__()
        self.all: list[Order] = []
        self._known: dict[str, Order] = {}
        self._items: dict[str, str] = {}
        timeline.on(OrderPlaced, self._place)
        timeline.on(OrderPickedUp, self._pick_up)
        timeline.on(OrderDelivered, self._end)
        timeline.on(OrderLost, self._end)
        timeline.on(OrderLate, self._mark_late)
        timeline.on((ItemPlaced, ItemDropped), self._put_down)

    def is_(self, order: str, state: str) -> bool:
        """Return whether an order is in a state; a late order is also in another one."""
        known = self._known.get(order)
        return known is not None and (known.late if state == "late" else known.state == state)

    def begin_anew(self) -> None:
        """Forget all orders; the open ones stay open in `all`."""
        known, self._known, self._items = self._known, {}, {}
        for name in known:
            self.changed(name)

    def _place(self, at: int, event: OrderPlaced) -> None:
        due = None if event.within is None else at + round(event.within * NANOSECONDS)
        order = Order(event.order, event.item, event.from_, event.to, event.priority, at, due)
        self.all.append(order)
        self._known[order.name], self._items[order.item] = order, order.name
        self.changed(order.name)

    def _pick_up(self, at: int, event: OrderPickedUp) -> None:
        order = self._order(at, event)
        order.robot, order.state = event.robot, "carried"
        order.picked_up = at if order.picked_up is None else order.picked_up
        self.changed(order.name)

    def _put_down(self, _at: int, event: ItemPlaced | ItemDropped) -> None:
        order = self._known.get(self._items.get(event.item, ""))
        if order is not None and order.state == "carried":
            order.state, order.robot = "waiting", ""
            self.changed(order.name)

    def _end(self, at: int, event: OrderDelivered | OrderLost) -> None:
        order = self._order(at, event)
        if isinstance(event, OrderDelivered):
            order.robot, order.state, order.ended = event.robot, "delivered", at
        else:
            order.state, order.ended = "lost", at
        self.changed(order.name)

    def _mark_late(self, at: int, event: OrderLate) -> None:
        order = self._order(at, event)
        order.late = True
        self.changed(order.name)

    def _order(self, at: int, event: OrderEvent) -> Order:
        """Return the order of an event, which a recording may lack from an earlier time."""
        return self._known.setdefault(event.order, Order(event.order, event.item, "", "", 0, at, None))
