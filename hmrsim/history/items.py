"""Where the items of a run are, and which robots carry them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from hmrsim.events.robots import ItemDropped, ItemPicked, ItemPlaced
from hmrsim.events.simulation import Deleted, Spawned, Teleported
from hmrsim.history.occurrence import SceneSeen, point, records, text
from hmrsim.history.timeline import Part

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.history.timeline import Timeline
    from hmrsim.world.model import World


@dataclass(slots=True)
class Item:
    """An item.

    Attributes:
        at: The point where it lies; None while it does not exist, or is carried from an unknown point.
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
        for lies in (ItemPlaced, ItemDropped):
            timeline.on(lies, lambda _at, event: self._set(event.item, event.at))
        for put in (Teleported, Spawned):
            timeline.on(put, self._put)
        timeline.on(Deleted, self._delete)
        timeline.on(SceneSeen, self._see)

    def __getitem__(self, name: str) -> Item:
        """Return an item, which may not exist yet."""
        return self._items.setdefault(name, Item())

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
