"""Checks of properties against a world: the names in them exist there, and their events can happen."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from hmrsim.actions import registry as actions
from hmrsim.diagnostics import Finding, Path, instead, warning
from hmrsim.events import EventPattern
from hmrsim.events.facilities import DOORS, LIFTS
from hmrsim.events.orders import EVENTS as ORDERS
from hmrsim.events.robots import BATTERIES, DOCKS, ITEMS, ScriptEnded
from hmrsim.events.traffic import Deadlock
from hmrsim.faults import registry as faults
from hmrsim.properties.model.conditions import (
    BatteryCondition,
    DoorCondition,
    FaultCondition,
    ItemCondition,
    LaneCondition,
    OrderCondition,
    RobotCondition,
)
from hmrsim.properties.model.part import BOUND, EACH, texts, walk
from hmrsim.properties.model.property import PatrollingPattern, VisitPattern
from hmrsim.protocol.goal import WORLD

if TYPE_CHECKING:
    from pydantic import BaseModel

    from hmrsim.properties.model.file import Properties
    from hmrsim.world.model import World

_PLACE: Final = "waypoint, place or dock"
_NUMBERED: Final = re.compile(r"(.+)_([1-9][0-9]*)")


def check_properties(properties: Properties, world: World) -> list[Finding]:
    """Return the parts of properties that do not fit a world.

    A name that the world lacks is an error. An event or state that can't occur in it is a warning, as the property says
    nothing.
    """
    names = _Names.of(world)
    return [
        finding
        for name, each in properties.properties.items()
        for path, part in walk(each, ("properties", name))
        for finding in _check(path, part, names)
    ]


@dataclass(frozen=True)
class _Names:
    """The names in a world."""

    world: World
    robots: Collection[str]
    powered: Collection[str]
    places: Collection[str]
    lanes: Collection[tuple[str, str]]

    @classmethod
    def of(cls, world: World) -> _Names:
        powered = [name for name, robot in world.robots.items() if "battery" in world.robot_type(robot).components]
        lanes = {(lane.from_, lane.to) for lane in world.lanes}
        back = {(lane.to, lane.from_) for lane in world.lanes if not lane.one_way}
        return cls(world, world.robots, powered, {**world.points, **world.places, **world.docks}, lanes | back)

    def demand_of(self, name: str, *, items: bool) -> bool | None:
        """Return whether the demand makes an order or an item of this name; None if the name is not one of a demand."""
        match = _NUMBERED.fullmatch(name)
        for spec in self.world.demand if match else ():
            called = (spec.item or spec.name) if items else spec.name
            if match and match[1] == called:
                return spec.count is None or items or int(match[2]) <= spec.count
        return None


def _check(path: Path, part: BaseModel, names: _Names) -> Iterator[Finding]:
    world = names.world
    match part:
        case VisitPattern() | PatrollingPattern():
            yield from _check_places(path, part, names)
        case RobotCondition():
            yield from _one_of((*path, "robot"), "robot", part.robot, names.robots)
            yield from _one_of((*path, "at"), _PLACE, part.at, names.places)
            if part.is_ == "charging" and part.robot in world.robots and part.robot not in names.powered:
                yield warning((*path, "is"), f"{part.robot} has no battery, and never charges", part.is_)
        case ItemCondition():
            yield from _item(path, part.item, names)
            yield from _one_of((*path, "at"), _PLACE, part.at, names.places)
            yield from _one_of((*path, "carried_by"), "robot", part.carried_by, names.robots)
        case BatteryCondition():
            yield from _battery(path, part.battery, names)
        case DoorCondition():
            yield from _one_of((*path, "door"), "door", part.door, world.doors)
        case EventPattern():
            yield from _pattern(path, part, names)
        case _:
            yield from _check_other(path, part, names)


def _check_other(path: Path, part: BaseModel, names: _Names) -> Iterator[Finding]:
    match part:
        case OrderCondition():
            yield from _order((*path, "order"), part.order, names)
        case FaultCondition():
            yield from _one_of((*path, "fault"), "kind of fault", part.fault, faults())
            yield from _one_of((*path, "robot"), "robot", part.robot, names.robots)
        case LaneCondition():
            if part.lane not in names.lanes:
                known = [f"{a}-{b}" for a, b in sorted(names.lanes)]
                lane = "-".join(part.lane)
                yield Finding((*path, "lane"), f"no lane {lane!r}{instead(lane, known)}", [*part.lane])


def _check_places(path: Path, part: VisitPattern | PatrollingPattern, names: _Names) -> Iterator[Finding]:
    yield from _one_of((*path, "robot"), "robot", part.robot, names.robots)
    for inner, place in texts(part):
        if len(inner) > 1:
            yield from _one_of((*path, *inner), _PLACE, place, names.places)


def _one_of(path: Path, noun: str, name: str | None, known: Collection[str]) -> Iterator[Finding]:
    if name is not None and not _stands_for_others(name) and name not in known:
        yield Finding(path, f"no {noun} {name!r}{instead(name, known)}", name)


def _stands_for_others(name: str) -> bool:
    return name == EACH or name.startswith(BOUND)


def _battery(path: Path, name: str, names: _Names) -> Iterator[Finding]:
    path = (*path, "battery")
    if name == EACH and not names.powered:
        yield warning(path, "no robot has a battery, so that this says nothing", name)
    elif name in names.robots and name not in names.powered:
        yield Finding(path, f"{name} has no battery{instead(name, names.powered, verb='these have one:')}", name)
    else:
        yield from _one_of(path, "robot", name, names.robots)


def _item(path: Path, name: str, names: _Names) -> Iterator[Finding]:
    if names.demand_of(name, items=True) is None:
        known = {*names.world.items, *(f"{spec.item or spec.name}_1" for spec in names.world.demand)}
        yield from _one_of((*path, "item"), "item", name, sorted(known))


def _order(path: Path, name: str, names: _Names) -> Iterator[Finding]:
    if _stands_for_others(name) or names.demand_of(name, items=False):
        return
    known = [f"{spec.name}_1" for spec in names.world.demand]
    yield warning(path, f"no demand brings an order {name!r}, so that only a client can{instead(name, known)}", name)


_SUBJECTS: Final = ("robot", "door", "dock", "lift", "item", "order")
"""Fields of events with the name of something in the world."""


def _pattern(path: Path, pattern: EventPattern, names: _Names) -> Iterator[Finding]:
    robots = {**dict.fromkeys(names.robots), WORLD: None}
    yield from _one_of((*path, "robot"), "robot", pattern.robot, robots)
    yield from _one_of((*path, "action"), "action", pattern.action, actions())
    for field in _SUBJECTS:
        value: Any = pattern.where.get(field)
        if isinstance(value, str):
            yield from _subject((*path, "where"), field, value, names)
    why = _impossible(pattern.event, names)
    if why:
        yield warning((*path, "event"), f"{pattern.event} never comes in this world: {why}", pattern.event)


def _subject(path: Path, field: str, value: str, names: _Names) -> Iterator[Finding]:
    world = names.world
    if field == "order":
        yield from _order((*path, field), value, names)
    elif field == "item":
        yield from _item(path, value, names)
    else:
        things: dict[str, Collection[str]] = {"door": world.doors, "dock": world.docks, "lift": world.lifts}
        known = things.get(field, world.robots)
        yield from _one_of((*path, field), field, value, known)


def _impossible(kind: str | None, names: _Names) -> str:
    """Return why events of a kind can't occur in a world; empty if they can."""
    world = names.world
    lacks = (
        (DOORS.events, not world.doors, "it has no doors"),
        (LIFTS.events, not world.lifts, "it has no lifts"),
        (DOCKS.events, not world.docks, "it has no docks"),
        (BATTERIES.events, not names.powered, "no robot has a battery"),
        (ORDERS.events, not world.demand, "it has no demand"),
        (ITEMS.events, not (world.items or world.demand), "it has no items"),
        ((ScriptEnded,), not any(robot.script for robot in world.robots.values()), "no robot has a script"),
        ((Deadlock,), world.policy == "free", "robots pass through each other under the traffic policy free"),
    )
    return next((why for events, lacking, why in lacks if lacking and any(kind == event.kind for event in events)), "")
