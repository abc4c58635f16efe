"""The checks of the demand of a world."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from contextlib import suppress
from typing import TYPE_CHECKING

from pydantic import ValidationError

from hmrsim.components.claw import ClawSettings
from hmrsim.diagnostics import Finding, instead, warning
from hmrsim.world_checks.facilities import Ways
from hmrsim.world_checks.robots import known_start

if TYPE_CHECKING:
    from hmrsim.documents.valid_parts import Lost
    from hmrsim.world.model import World


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


def check_orders(world: World, lost: Lost) -> Iterator[Finding]:
    """Yield a warning for each demand whose items no robot lifts, or that has a place that no such robot can reach.

    There is none in a world without claws, nor for a place in an obstacle, which a claw may reach into.
    """
    payloads = {} if lost or not world.demand else _payloads(world)
    if not payloads:
        return
    ways, most = Ways(world), max(payloads.values())
    for i, spec in enumerate(world.demand):
        if spec.weight > most:
            message = f"no robot lifts {spec.weight:g} kg (at most {most:g} kg)"
            yield warning(("demand", i, "weight"), message, spec.weight)
        carriers = {name: world.robots[name] for name, payload in payloads.items() if spec.weight <= payload}
        for field, places in (("at", spec.at), ("to", spec.to)):
            for place in places:
                point = world.find(place)
                if point and not ways.is_walled(point) and (message := ways.missing(place, point, carriers)):
                    yield warning(("demand", i, field), message, place)


def _payloads(world: World) -> dict[str, float]:
    """Return how many kg each robot with a claw lifts, as far as its settings are valid."""
    payloads = {}
    for name, robot in world.robots.items():
        base, _ = known_start(world, robot)
        claw = world.robot_type(robot).components.get("claw") if base else None
        with suppress(ValidationError):
            if claw is not None:
                payloads[name] = ClawSettings.model_validate(claw).max_weight or math.inf
    return payloads
