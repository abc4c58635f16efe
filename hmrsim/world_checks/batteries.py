"""The checks of robots' batteries."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, Final

from pydantic import ValidationError

from hmrsim.actions import registry
from hmrsim.components.battery import BatterySettings
from hmrsim.diagnostics import Finding, instead, warning

if TYPE_CHECKING:
    from hmrsim.diagnostics import Path
    from hmrsim.world.model import World

_NEXT_TO_NOTHING: Final = 0.02
"""A charge of at most one unit, which is less than this share of the capacity, may be meant as a share."""


def check_batteries(world: World) -> Iterator[Finding]:
    """Yield the actions that drain a battery and that there are not, and charges that may be meant as shares."""
    kinds = world.robot_types
    carriers: tuple[tuple[Path, Mapping[str, Any], Mapping[str, Any]], ...] = (
        *((("robot_types", name), kind.components, {}) for name, kind in kinds.items()),
        *(
            (("robots", name), robot.components, kinds[robot.type].components if robot.type in kinds else {})
            for name, robot in world.robots.items()
        ),
    )
    for place, components, inherited in carriers:
        own = components.get("battery") or {}
        path: Path = (*place, "components", "battery")
        yield from _missing_actions(path, own.get("drain"))
        yield from _doubtful_charge(path, own, {**(inherited.get("battery") or {}), **own})


def _missing_actions(path: Path, drain: object) -> Iterator[Finding]:
    actions = drain.get("actions") if isinstance(drain, dict) else None
    for action in actions if isinstance(actions, dict) else ():
        if action not in registry():
            message = f"no action {action!r}{instead(str(action), registry())}"
            yield Finding((*path, "drain", "actions", action), message, action)


def _doubtful_charge(path: Path, own: Mapping[str, Any], settings: Mapping[str, Any]) -> Iterator[Finding]:
    if own.get("initial_charge") is None:
        return
    try:
        battery = BatterySettings.model_validate(settings)
    except ValidationError:
        # That is told elsewhere.
        return
    charge, capacity = battery.initial_charge, battery.capacity
    if charge is not None and 0 < charge <= 1 < capacity * _NEXT_TO_NOTHING:
        message = f"{charge:g} of {capacity:g} units is next to nothing; {charge:.0%} of it are {charge * capacity:g}"
        yield warning((*path, "initial_charge"), message, charge)
