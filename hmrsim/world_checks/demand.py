"""The checks of the demand: its places exist, and its names are its own."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING

from hmrsim.diagnostics import Finding, instead

if TYPE_CHECKING:
    from hmrsim.world.model import World
    from hmrsim.world_checks.validation import Lost


def check_demand(world: World, lost: Lost) -> Iterator[Finding]:
    """Yield the errors of the demand of a world."""
    known = {**world.points, **world.places, **world.docks} if world.demand else {}
    entities = {**world.items, **world.robots, **world.docks, **world.doors, **world.lifts} if world.demand else {}
    numbered = [(match[1], name) for name in entities if (match := re.fullmatch(r"(.+)_[0-9]+", name, re.DOTALL))]
    taken = dict(reversed(numbered))
    names: set[str] = set()
    for i, spec in enumerate(world.demand):
        for field, places in (("at", spec.at), ("to", spec.to)):
            for place in places:
                if place not in known and not lost.has(place, "waypoints", "places", "docks"):
                    message = f"no waypoint, place or dock {place!r}{instead(place, known)}"
                    yield Finding(("demand", i, field), message, place)
        if spec.name in names:
            yield Finding(("demand", i, "name"), f"there is a demand {spec.name!r} already", spec.name)
        names.add(spec.name)
        item = spec.item or spec.name
        if item in taken:
            message = f"its items are called {item}_1 and so on, as {taken[item]!r} is already; give another item"
            yield Finding(("demand", i, "item" if spec.item else "name"), message, item)
