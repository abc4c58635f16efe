"""The checks of robots' scripts: every order is valid, and the robot has the component that it needs."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from hmrsim.diagnostics import Finding, shown
from hmrsim.goals.script_orders import read_order

if TYPE_CHECKING:
    from hmrsim.diagnostics import Path
    from hmrsim.world.model import World
    from hmrsim.world_checks.validation import Lost

_NAMED = frozenset(("waypoints", "places", "docks", "items", "robot_types"))
"""Top-level keys of what orders and robots name."""


def check_scripts(world: World, lost: Lost) -> Iterator[Finding]:
    """Yield the errors of the scripts, without those that may follow from parts left out of the world."""
    if not _NAMED.isdisjoint(lost.names):
        return
    for name, robot in world.robots.items():
        for i, text in enumerate(robot.script):
            yield from _check_order(world, name, ("robots", name, "script", i), text)


def _check_order(world: World, robot: str, path: Path, text: str) -> Iterator[Finding]:
    try:
        order = read_order(text, world)
    except ValueError as error:
        yield Finding(path, str(error), text)
        return
    needed = order.action.component
    try:
        carried = world.robot_type(world.robots[robot]).components
    except KeyError:
        # Its type is not there, which is said where it is named.
        return
    if needed is not None and needed not in carried:
        yield Finding(path, f"{shown(text)} takes a {needed}, which {robot} does not have", text)
