"""The checks of robots: batteries, scripts, and starts from which they can't get on the lanes."""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final

from pydantic import ValidationError

from hmrsim.actions import registry
from hmrsim.components.battery import BatterySettings
from hmrsim.diagnostics import Finding, instead, shown, warning
from hmrsim.geometry import SAME_PLACE, Obstacles, distance, foot
from hmrsim.goals.script_orders import read_order
from hmrsim.world.network import nearest

if TYPE_CHECKING:
    from hmrsim.diagnostics import Path
    from hmrsim.geometry import Point
    from hmrsim.world.model import World
    from hmrsim.world_checks.validation import Lost

_NEXT_TO_NOTHING: Final = 0.02
"""A charge of at most one unit and below this share of the capacity may be meant as a share."""

_NAMED = frozenset(("waypoints", "places", "docks", "items", "robot_types"))
"""The top-level keys whose names can be missing from scripts and robots."""

_NEAREST = 24
"""Walls around a robot that are checked first, as they include those that wall it in."""

_MAX_COMPARISONS = 2_000_000
"""Maximum comparisons of lanes and walls for all robots that don't see the nearest waypoint: some seconds."""


def check_batteries(world: World) -> Iterator[Finding]:
    """Yield an error for each unknown action that drains a battery, and a warning for charges that look like shares."""
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
        # Reported by the checks of components.
        return
    charge, capacity = battery.initial_charge, battery.capacity
    if charge is not None and 0 < charge <= 1 < capacity * _NEXT_TO_NOTHING:
        message = f"{charge:g} of {capacity:g} units is next to nothing; {charge:.0%} of it are {charge * capacity:g}"
        yield warning((*path, "initial_charge"), message, charge)


def check_scripts(world: World, lost: Lost) -> Iterator[Finding]:
    """Yield the errors of scripts, without those that may follow from invalid parts."""
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
        # The unknown type has another error.
        return
    if needed is not None and needed not in carried:
        yield Finding(path, f"{shown(text)} takes a {needed}, which {robot} does not have", text)


def check_walled_in(world: World, lost: Lost) -> Iterator[Finding]:
    """Yield a warning for each robot that can't get on a lane from its start, or can't leave its waypoint.

    Without lanes robots drive straight, so that there is no warning. Robots in an obstacle have another warning.
    """
    starts = {} if lost else _starts(world)
    if not starts:
        return
    points, lanes = world.points, [(lane.from_, lane.to, lane.one_way) for lane in world.lanes]
    lanes = [lane for lane in lanes if lane[0] in points and lane[1] in points]
    left = {points[start] for start, _, _ in lanes} | {points[end] for _, end, one_way in lanes if not one_way}
    left |= {points[stop] for lift in world.lifts.values() for stop in lift.stops if stop in points}
    reached = {points[end]: end for _, end, _ in lanes}
    off = {name: point for name, point in starts.items() if point not in left}
    for name in [name for name, point in off.items() if point in reached]:
        end = reached[off.pop(name)]
        yield warning(("robots", name, "at"), f"no lane leads out of {end!r}; start it elsewhere", end)
    if not (off and lanes):
        return
    sight = _Sight(world, [(points[start], points[end]) for start, end, _ in lanes])
    beside = nearest({name: points[name] for lane in lanes for name in lane[:2]}, off)
    for name, (x, y) in off.items():
        if not sight.leads_from((x, y), points[beside[name]]):
            message = f"({x:g}, {y:g}) is walled in: no straight line leads to a lane; start it where one does"
            yield warning(("robots", name, "at"), message, [x, y])


def _starts(world: World) -> dict[str, Point]:
    """Return the known starts of robots that drive on lanes, by name."""
    found = {}
    for name, robot in world.robots.items():
        try:
            base, point = world.robot_type(robot).base, world.point(robot.at)
        except KeyError:
            continue
        if not base.flies and robot.planner == "graph":
            found[name] = point
    return found


class _Sight:
    """The lanes of a world, and the obstacles between them and points beside them."""

    def __init__(self, world: World, lanes: list[tuple[Point, Point]]) -> None:
        solids = [wall.solid for wall in world.walls if not isinstance(wall, tuple)]
        walls = [wall for wall in world.walls if isinstance(wall, tuple)]
        # Off the lanes a door is a wall for the planner.
        doors = [door.at for door in world.doors.values()]
        self._obstacles = Obstacles([*walls, *doors], solids)
        self._told = Obstacles(doors, solids)
        self._walls = [
            pair for wall in [*walls, *doors, *((*solid, solid[0]) for solid in solids)] for pair in pairwise(wall)
        ]
        self._lanes = lanes
        self._budget = _MAX_COMPARISONS

    def leads_from(self, point: Point, waypoint: Point) -> bool:
        """Return whether a straight line leads to a lane, or the limit is reached; *waypoint* is the nearest.

        A point in an obstacle or a door counts as one from which a line leads.
        """
        if not self._obstacles.block(point, waypoint) or self._told.occupy(point):
            return True
        nearest_walls = heapq.nsmallest(_NEAREST, self._walls, key=lambda wall: distance(point, foot(point, *wall)))
        around = Obstacles(nearest_walls, ())
        for lane in self._lanes:
            self._budget -= len(nearest_walls)
            if self._budget < 0:
                return True
            if _sees(point, lane, around):
                self._budget -= len(self._walls)
                if _sees(point, lane, self._obstacles):
                    return True
        return False


def _sees(point: Point, lane: tuple[Point, Point], obstacles: Obstacles) -> bool:
    """Return whether a point is on a lane, or sees its foot on it or the end of the shadow around it."""
    at = foot(point, *lane)
    if distance(point, at) <= SAME_PLACE:
        return True
    seen = (at, *obstacles.edges_of_shadow(point, *lane))
    return any(not obstacles.block(point, there) for there in seen)
