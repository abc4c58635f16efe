"""The overlay of ``hmrsim map render --bottlenecks``."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal

from hmrsim.cli.output import warn
from hmrsim.drawing import Overlay, Weak
from hmrsim.topology import bottlenecks, concentration, speeds_of

if TYPE_CHECKING:
    from hmrsim.topology import Bottleneck, Bottlenecks, Concentration
    from hmrsim.world import World


def overlay_of(world: World, theme: Literal["light", "dark"]) -> Overlay:
    """Return the traffic and the bottlenecks of a world to draw; warn of what is omitted in a large map."""
    traffic = concentration(world.graph, next(iter(speeds_of(world))))
    found = bottlenecks(world.graph)
    if note := _limits(traffic, found):
        warn(f"hmrsim: {note}")
    weak = tuple(_weak(world, one) for one in found.worst)
    return Overlay(traffic.shares if traffic else {}, weak, theme)


def _limits(traffic: Concentration | None, found: Bottlenecks) -> str:
    """Return what is omitted or inexact, as the map is large."""
    notes = []
    if traffic is None:
        notes.append("traffic is not drawn: there are too many lanes")
    elif traffic.starts < traffic.of:
        notes.append(f"traffic is counted from a sample of {traffic.starts} of {traffic.of} waypoints")
    total = found.waypoints + found.lanes + found.lifts
    if len(found.worst) < total:
        notes.append(f"the worst {len(found.worst)} of {total} bottlenecks are drawn")
    return "; ".join(notes)


def _weak(world: World, one: Bottleneck) -> Weak:
    sizes = [side.waypoints for side in one.sides]
    names = world.lifts[one.name[0]].stops if one.kind == "lift" else one.name
    apart = " | ".join(f"{side.waypoints} waypoints, {len(side.places)} places" for side in one.sides)
    weight = math.sqrt(min(1.0, 2 * (sum(sizes) - sizes[0]) / sum(sizes)))
    return Weak(names, one.kind, weight, f"{' - '.join(one.name)} is the only way between {apart}")
