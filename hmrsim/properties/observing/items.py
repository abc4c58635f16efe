"""Where items are, and who carries them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from hmrsim.events.robots import ItemDropped, ItemPicked, ItemPlaced
from hmrsim.events.simulation import Deleted, Spawned, Teleported
from hmrsim.geometry import distance
from hmrsim.history.occurrence import SceneSeen, point, records, text
from hmrsim.properties.observing.positions import point_of
from hmrsim.properties.observing.signal import Signal
from hmrsim.simulation.demand import NEAR

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.history.timeline import Timeline
    from hmrsim.properties.observing.positions import Positions
    from hmrsim.properties.results import ItemEnd
    from hmrsim.world.model import World


@dataclass(slots=True)
class _Item:
    """What is known of an item.

    Attributes:
        at: Where it lies, or was picked up; None if it is nowhere.
        carrier: Who carries it; empty for nobody.
        signals: What is said of it, by what that is, each with what updates it.
    """

    at: Point | None = None
    carrier: str = ""
    signals: dict[str, tuple[Signal, _Look]] = field(default_factory=dict)


_Look = Callable[[_Item, Signal], None]
"""Updates a signal of an item."""


class Items:
    """Follows the items of a world.

    Args:
        positions: Returns where robots are, as an item is where its carrier is.
    """

    def __init__(self, world: World, timeline: Timeline, positions: Callable[[], Positions]) -> None:
        self._world, self._positions = world, positions
        self._radius = NEAR[world.units]
        self._items: dict[str, _Item] = {}
        self.begin_anew()
        timeline.on(ItemPicked, lambda _at, event: self._change(event.item, None, event.robot))
        for lies in (ItemPlaced, ItemDropped):
            timeline.on(lies, lambda _at, event: self._change(event.item, event.at, ""))
        for put in (Teleported, Spawned):
            timeline.on(put, self._put)
        timeline.on(Deleted, self._delete)
        timeline.on(SceneSeen, self._see)

    def lies_at(self, item: str, place: str) -> Signal:
        """Return whether an item lies at a place, and nobody carries it."""
        where = point_of(self._world, place)

        def look(known: _Item, signal: Signal) -> None:
            near = where is not None and known.at is not None and distance(known.at, where) <= self._radius
            signal.say(holds=near and not known.carrier)

        return self._following(item, f"lies at {place}", look)

    def as_in(self, item: str, end: ItemEnd) -> Signal:
        """Return whether an item is where it was at the end of another run: it lies near there, or is carried."""

        def look(known: _Item, signal: Signal) -> None:
            near = known.at is not None and distance(known.at, end.at) <= self._radius
            signal.say(holds=bool(known.carrier) if end.carried else near and not known.carrier)

        return self._following(item, f"as in {end}", look)

    def at(self, item: str, place: str) -> Signal:
        """Return whether an item is at a place, where it lies or is carried."""
        lies, carriers = self.lies_at(item, place), dict[str, Signal]()

        def follow(robot: str) -> None:
            carriers[robot] = self._positions().near(robot, place)
            carriers[robot].tell(lambda: look(self._item(item), found))

        def look(known: _Item, signal: Signal) -> None:
            if not known.carrier:
                signal.set(lies.value)
                return
            if known.carrier not in carriers:
                follow(known.carrier)
            signal.set(carriers[known.carrier].value)

        found = self._following(item, f"at {place}", look)
        # Where a robot is when it picks the item up follows from how it has come there.
        for name, robot in self._world.robots.items():
            if name not in carriers and "claw" in self._world.robot_type(robot).components:
                follow(name)
        return found

    def carried(self, item: str, by: str | None) -> Signal:
        """Return whether an item is carried; by a robot, or by any."""

        def look(known: _Item, signal: Signal) -> None:
            signal.say(holds=bool(known.carrier) and by in (None, known.carrier))

        return self._following(item, f"carried by {by}", look)

    def _following(self, name: str, what: str, look: _Look) -> Signal:
        """Return the signal of what is said of an item, which is updated whenever the item changes."""
        item = self._item(name)
        if what not in item.signals:
            signal = Signal()
            item.signals[what] = signal, look
            look(item, signal)
        return item.signals[what][0]

    def _item(self, name: str) -> _Item:
        return self._items.setdefault(name, _Item())

    def begin_anew(self) -> None:
        """Put all items to where they are at the start."""
        for name in [*self._items]:
            if name not in self._world.items:
                self._change(name, None, "")
        for name, item in self._world.items.items():
            self._change(name, self._world.point(item.at), "")

    def _change(self, name: str, at: Point | None, carrier: str) -> None:
        item = self._item(name)
        item.at, item.carrier = at, carrier
        for signal, look in item.signals.values():
            look(item, signal)

    def _put(self, _at: int, event: Teleported | Spawned) -> None:
        if event.entity in self._items or (isinstance(event, Spawned) and event.type == "item"):
            self._change(event.entity, event.at, "")

    def _delete(self, _at: int, event: Deleted) -> None:
        if event.entity in self._items:
            self._change(event.entity, None, "")

    def _see(self, _at: int, scene: SceneSeen) -> None:
        said = {text(item, "name"): item for item in records(scene.fields, "items")}
        for name in [*self._items, *said]:
            if name not in said:
                self._change(name, None, "")
            else:
                carried = said[name].get("carrier") is not None
                self._change(name, point(said[name], "at"), text(said[name], "carrier") if carried else "")
