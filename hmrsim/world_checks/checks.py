"""The checks of a world that need more than one field."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from itertools import islice
from typing import TYPE_CHECKING

from hmrsim.actions import registry
from hmrsim.components import registry as components
from hmrsim.diagnostics import MAX_FINDINGS, Finding, Path, dotted, instead, warning
from hmrsim.documents.valid_parts import Lost, valid_parts
from hmrsim.geometry import SAME_PLACE, Obstacles, distance
from hmrsim.world.model import BUILT_IN_TYPES
from hmrsim.world_checks.demand import check_demand, check_orders
from hmrsim.world_checks.facilities import check_docks, check_fixtures, check_lanes_through_doors, check_ways_to_docks
from hmrsim.world_checks.faults import check_faults
from hmrsim.world_checks.lanes import LaneIndex, check_lanes, known_lanes, off_the_map
from hmrsim.world_checks.robots import check_batteries, check_scripts, check_traffic, check_walled_in

if TYPE_CHECKING:
    from typing import Any

    from hmrsim.geometry import Point
    from hmrsim.world.model import RobotSpec, World

_CHUNKS = re.compile(r"[A-Za-z0-9][A-Za-z0-9_]*/[A-Za-z0-9_]+")


def check(world: World, lost: Lost | None = None) -> list[Finding]:
    """Return the errors and warnings of a world, at most `MAX_FINDINGS` of each kind.

    Errors that only follow from the parts that are *lost* from it are not reported. Its includes are merged.
    """
    lost = lost or Lost()
    checks = (check_ways_to_docks, check_walled_in, check_lanes_through_doors, check_orders)
    warnings = [finding for find in checks for finding in islice(find(world, lost), MAX_FINDINGS)]
    return [*check_errors(world, lost), *warnings]


def check_errors(world: World, lost: Lost) -> list[Finding]:
    """Return the errors of a world, and the warnings that the same checks find."""
    checks = (
        _check_bounds(world),
        _check_names(world),
        check_lanes(world, lost),
        check_docks(world, lost),
        _check_robot_types(world),
        _check_robots(world, lost),
        _check_items(world, lost),
        check_fixtures(world, lost),
        _check_inside(world),
        check_batteries(world),
        check_traffic(world, lost),
        check_faults(world, lost),
        check_demand(world, lost),
        _check_remap(world, lost),
        check_scripts(world, lost),
    )
    return [finding for found in checks for finding in islice(found, MAX_FINDINGS)]


def _check_bounds(world: World) -> Iterator[Finding]:
    if world.bounds is None:
        return
    x0, y0, x1, y1 = world.bounds
    for axis, least, greatest in (("x", x0, x1), ("y", y0, y1)):
        if least >= greatest:
            yield Finding(
                ("bounds",),
                f"least {axis} {least:g} must be below greatest {axis} {greatest:g};"
                " expected [least x, least y, greatest x, greatest y]",
                list(world.bounds),
            )


def _check_names(world: World) -> Iterator[Finding]:
    """Yield an error for each place or dock whose name another point has."""
    named: list[tuple[Path, str, Point]] = [
        *((("places", name, "at"), name, place.at) for name, place in world.places.items()),
        *((("docks", name, "at"), name, dock.at) for name, dock in world.docks.items() if not isinstance(dock.at, str)),
    ]
    first: dict[str, tuple[Path, Point]] = {}
    for path, name, point in named:
        if name in world.points:
            first[name] = ("waypoints", name), world.points[name]
        where, other = first.setdefault(name, (path, point))
        if distance(point, other) > SAME_PLACE:
            yield Finding(
                path,
                f"{_at(point)} is another point than {dotted(where)}, which is {_at(other)};"
                f" give one of the two another name",
                list(point),
            )


def _at(point: Point) -> str:
    return f"({point[0]:g}, {point[1]:g})"


def _check_inside(world: World) -> Iterator[Finding]:
    x0, y0, x1, y1 = world.bounds or (-math.inf, -math.inf, math.inf, math.inf)
    # A grid has a million waypoints; the docks have their own check.
    strays = {name: (x, y) for name, (x, y) in world.points.items() if not (x0 <= x <= x1 and y0 <= y <= y1)}
    points: list[tuple[Path, Point]] = [(("waypoints", name), point) for name, point in strays.items()]
    points += [(("places", name, "at"), place.at) for name, place in world.places.items()]
    points += [(("items", name, "at"), item.at) for name, item in world.items.items() if not isinstance(item.at, str)]
    for path, point in points:
        yield from off_the_map(world, path, point, "warning")


def _point(world: World, at: Point | str, path: Path, lost: Lost) -> Point | Finding | None:
    """Return the point of *at*, or its error, or None if an invalid part may define it."""
    point, name = world.find(at), str(at)
    # Another check reports a dock at an unknown place.
    if point is not None or name in world.docks or lost.has(name, "waypoints", "places", "docks"):
        return point
    known = [*world.waypoints, *world.places, *world.docks]
    return Finding(path, f"no waypoint, place or dock {name!r}{instead(name, known)}", name)


def _check_settings(path: Path, name: str, settings: Mapping[str, Any]) -> Iterator[Finding]:
    component = components().get(name)
    if component is None:
        yield Finding(path, f"no component {name!r}{instead(name, components())}", name)
        return
    for finding in valid_parts(settings, component.settings).findings:
        yield finding.within(*path)


def _check_robot_types(world: World) -> Iterator[Finding]:
    for kind, robot_type in world.robot_types.items():
        for name, settings in robot_type.components.items():
            yield from _check_settings(("robot_types", kind, "components", name), name, settings)


def _check_robots(world: World, lost: Lost) -> Iterator[Finding]:
    if not world.robots:
        return
    solids = Obstacles([], world.solids)
    lanes = cache(lambda: LaneIndex(world, known_lanes(world)))
    types = {**world.robot_types, **BUILT_IN_TYPES}
    for name, robot in world.robots.items():
        yield from _check_own_components(world, name, robot)
        if robot.type not in types and not lost.has(robot.type, "robot_types"):
            message = f"no robot type {robot.type!r}{instead(robot.type, types)}"
            yield Finding(("robots", name, "type"), message, robot.type)
        path: Path = ("robots", name, "at")
        point = _point(world, robot.at, path, lost)
        if isinstance(point, Finding):
            yield point
        elif point is not None:
            yield from _check_start(world, path, point, solids, lanes)


def _check_own_components(world: World, name: str, robot: RobotSpec) -> Iterator[Finding]:
    """Yield the errors of a robot's own components; those of its type are checked there."""
    kind = world.robot_types.get(robot.type) or BUILT_IN_TYPES.get(robot.type)
    inherited = kind.components if kind else {}
    for key, own in robot.components.items():
        path: Path = ("robots", name, "components", key)
        if own is None:
            if kind and key not in inherited:
                message = f"{robot.type!r} has no component {key!r} to take away{instead(key, inherited)}"
                yield warning(path, message, key)
            continue
        for finding in _check_settings(path, key, {**inherited.get(key, {}), **own}):
            if len(finding.path) <= len(path) or finding.path[len(path)] in own or key not in inherited:
                yield finding


def _check_start(
    world: World, path: Path, point: Point, solids: Obstacles, lanes: Callable[[], LaneIndex]
) -> Iterator[Finding]:
    yield from off_the_map(world, path, point)
    if solids.occupy(point):
        if lanes().lanes_at(point):
            yield warning(path, f"{_at(point)} is inside an obstacle; only its lane leads out", list(point))
        else:
            message = f"{_at(point)} is inside an obstacle, and on no lane that leads out; start it elsewhere"
            yield Finding(path, message, list(point))


def _check_items(world: World, lost: Lost) -> Iterator[Finding]:
    for name, item in world.items.items():
        point = _point(world, item.at, ("items", name, "at"), lost)
        if isinstance(point, Finding):
            yield point


def _check_remap(world: World, lost: Lost) -> Iterator[Finding]:
    targets = {target for alias, target in world.remap.items() if alias != target}
    for alias, target in world.remap.items():
        path: Path = ("remap", alias)
        if not _CHUNKS.fullmatch(alias):
            message = f"alias {alias!r} must be two words with a slash between, such as wall_e/grab"
            yield Finding(path, message, alias)
        elif alias in targets:
            yield Finding(path, f"alias {alias!r} is the name of an action already; choose another", alias)
        robot, slash, action = target.partition("/")
        if not slash or not _CHUNKS.fullmatch(f"{robot}/{action}"):
            message = f"target {target!r} must be <robot>/<action>, such as wall_e/pickup"
            yield Finding(path, message, target)
        elif robot not in world.robots and not lost.has(robot, "robots"):
            yield Finding(path, f"no robot {robot!r} for {target!r}{instead(robot, world.robots)}", target)
        elif action not in registry():
            yield Finding(path, f"no action {action!r} for {target!r}{instead(action, registry())}", target)
        elif alias == target:
            yield warning(path, f"alias {alias!r} is the same as its target", alias)
