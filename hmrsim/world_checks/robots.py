"""The checks of robots and traffic: batteries, scripts, start positions, and the traffic policy."""

from __future__ import annotations

import heapq
import math
import re
from collections import Counter, deque
from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

from pydantic import ValidationError

from hmrsim.actions import registry
from hmrsim.components.battery import BatterySettings
from hmrsim.diagnostics import Finding, instead, shown, warning
from hmrsim.documents.valid_parts import Lost, valid_parts
from hmrsim.geometry import SAME_PLACE, Obstacles, distance, foot
from hmrsim.goals.script_orders import read_order
from hmrsim.traffic.nearness import rooms_of_waypoints
from hmrsim.traffic.policies import registry as policies
from hmrsim.traffic.policies.reserve import ReserveSettings
from hmrsim.world.model import BUILT_IN_TYPES, DEFAULT_POLICY
from hmrsim.world.network import nearest
from hmrsim.world_checks.lanes import LaneIndex, known_lanes

if TYPE_CHECKING:
    from hmrsim.diagnostics import Path
    from hmrsim.geometry import Point
    from hmrsim.world.model import Base, RobotSpec, World


_MIN_SHARE: Final = 0.02
"""A charge of at most one unit and below this share of the capacity was probably meant as a share."""

_NAMED = ("waypoints", "places", "docks", "items", "robots")
"""The top-level keys with names that scripts refer to."""

_NEAREST = 24
"""Walls nearest to a robot that are checked first, since they block most lines."""

_MAX_COMPARISONS = 2_000_000
"""Maximum comparisons of lanes with walls, for all robots together: a few seconds."""


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
    battery = valid_battery(settings)
    charge, capacity = (battery.initial_charge, battery.capacity) if battery else (None, 0.0)
    if charge is not None and 0 < charge <= 1 < capacity * _MIN_SHARE:
        message = f"{charge:g} of {capacity:g} units is next to nothing; {charge:.0%} of it are {charge * capacity:g}"
        yield warning((*path, "initial_charge"), message, charge)


def valid_battery(settings: Any) -> BatterySettings | None:
    """Return the settings of a battery, or None if they are invalid, which the checks of components report."""
    try:
        return BatterySettings.model_validate(settings)
    except ValidationError:
        return None


def check_scripts(world: World, lost: Lost) -> Iterator[Finding]:
    """Yield the errors of scripts, except those that may follow from other invalid parts of the world."""
    for name, robot in world.robots.items():
        for i, text in enumerate(robot.script):
            yield from _check_order(world, lost, name, ("robots", name, "script", i), text)


def _check_order(world: World, lost: Lost, name: str, path: Path, text: str) -> Iterator[Finding]:
    robot = world.robots[name]
    try:
        needed = read_order(text, world).action.component
        components = world.robot_type(robot).components
    except ValueError as error:
        _, _, named = text.strip().partition(" ")
        names = (named, *re.split(r"[\s,]+", named))
        nowhere = (each in world.docks and world.find(each) is None for each in names)
        if not any(nowhere) and not any(lost.has(each, *_NAMED) for each in names):
            yield Finding(path, str(error), text)
        return
    except KeyError:
        # Another check reports the unknown place or type.
        return
    if needed is not None and needed not in components and not components_lost(robot, name, lost):
        yield Finding(path, f"{shown(text)} takes a {needed}, which {name} does not have", text)


def components_lost(robot: RobotSpec, name: str, lost: Lost) -> bool:
    """Return whether some components of a robot may be missing because its entry or its type is invalid."""
    return lost.has(name, "robots") or lost.has(robot.type, "robot_types")


def check_walled_in(world: World, lost: Lost) -> Iterator[Finding]:
    """Yield a warning for each robot that can't reach a lane from its start, or can't leave its waypoint.

    There is no warning in a world without lanes, where robots drive straight, nor for a robot in an obstacle, which
    another check reports.
    """
    starts = {} if lost else _starts(world)
    if not starts:
        return
    points, lanes = world.points, [(lane.from_, lane.to, lane.one_way) for lane in world.lanes]
    lanes = [lane for lane in lanes if lane[0] in points and lane[1] in points]
    exits = {points[start] for start, _, _ in lanes} | {points[end] for _, end, one_way in lanes if not one_way}
    exits |= {points[stop] for lift in world.lifts.values() for stop in lift.stops if stop in points}
    ends = {points[end]: end for _, end, _ in lanes}
    off = {name: point for name, point in starts.items() if point not in exits}
    for name in [name for name, point in off.items() if point in ends]:
        end = ends[off.pop(name)]
        yield warning(("robots", name, "at"), f"no lane leads out of {end!r}; start it elsewhere", end)
    if not (off and lanes):
        return
    sight = _Sight(world, [(points[start], points[end]) for start, end, _ in lanes])
    waypoints = nearest({name: points[name] for lane in lanes for name in lane[:2]}, off)
    for name, (x, y) in off.items():
        if not sight.leads_from((x, y), points[waypoints[name]]):
            message = f"({x:g}, {y:g}) is walled in: no straight line leads to a lane; start it where one does"
            yield warning(("robots", name, "at"), message, [x, y])


def _starts(world: World) -> dict[str, Point]:
    """Return the valid start positions of robots that drive on lanes, by name."""
    starts = {}
    for name, robot in world.robots.items():
        base, point = known_start(world, robot)
        if base and point and not base.flies and robot.planner == "graph":
            starts[name] = point
    return starts


def known_start(world: World, robot: RobotSpec) -> tuple[Base, Point] | tuple[None, None]:
    """Return the base of a robot and where it starts; None if its type or place is unknown."""
    point = world.find(robot.at)
    is_known = robot.type in world.robot_types or robot.type in BUILT_IN_TYPES
    return (world.robot_type(robot).base, point) if is_known and point else (None, None)


class _Sight:
    """Lines of sight to the lanes of a world, past its obstacles."""

    def __init__(self, world: World, lanes: list[tuple[Point, Point]]) -> None:
        # Away from the lanes, the planner treats doors as walls.
        doors = [door.at for door in world.doors.values()]
        self._obstacles = world.obstacles(doors=True)
        # Another check reports robots inside these.
        self._occupiable = Obstacles(doors, world.solids)
        self._walls = [*world.sides, *doors]
        self._lanes = lanes
        self._budget = _MAX_COMPARISONS

    def leads_from(self, point: Point, waypoint: Point) -> bool:
        """Return whether a straight line leads from a point to a lane; *waypoint* is the nearest one.

        The answer is also True for a point in an obstacle or a door, and when the limit of comparisons is reached.
        """
        if not self._obstacles.block(point, waypoint) or self._occupiable.occupy(point):
            return True
        nearest_walls = heapq.nsmallest(_NEAREST, self._walls, key=lambda wall: distance(point, foot(point, *wall)))
        nearby = Obstacles(nearest_walls, ())
        for lane in self._lanes:
            self._budget -= len(nearest_walls)
            if self._budget < 0:
                return True
            if _sees(point, lane, nearby):
                self._budget -= len(self._walls)
                if _sees(point, lane, self._obstacles):
                    return True
        return False


def _sees(point: Point, lane: tuple[Point, Point], obstacles: Obstacles) -> bool:
    """Return whether a point is on a lane, or sees its foot on the lane or the edge of a shadow around the foot."""
    at = foot(point, *lane)
    if distance(point, at) <= SAME_PLACE:
        return True
    targets = (at, *obstacles.edges_of_shadow(point, *lane))
    return any(not obstacles.block(point, target) for target in targets)


def check_traffic(world: World, lost: Lost | None = None) -> Iterator[Finding]:
    """Yield the errors and warnings of the traffic of a world.

    There are none under a default policy if robots are lost: with them it could be another one.
    """
    lost = lost or Lost()
    by_default = world.traffic.policy is None
    if by_default and lost.touches("robots", "robot_types", "traffic"):
        return
    policy = policies().get(world.policy)
    if policy is None:
        message = f"no traffic policy {world.policy!r}{instead(world.policy, policies())}"
        yield Finding(("traffic", "policy"), message, world.policy)
        return
    said = world.traffic.model_dump()
    valid = valid_parts(said, policy.settings)
    hint = f" (the policy is {policy.name!r} by default; set another one)" if by_default else ""
    for finding in valid.findings:
        yield Finding(("traffic", *finding.path), f"{finding.message}{hint}", finding.value)
    if valid.findings:
        return
    if isinstance(valid.value, ReserveSettings):
        yield from _check_starts(world, valid.value, lost)
    elif by_default:
        yield from _check_capacities(world)


def _check_capacities(world: World) -> Iterator[Finding]:
    """Yield a warning at the first capacity of a world whose robots pass through each other by default."""
    found: list[tuple[Path, int | None]] = [
        *(
            (("waypoints", name, "capacity"), getattr(point, "capacity", None))
            for name, point in world.waypoints.items()
        ),
        *((("lanes", i, "capacity"), lane.capacity) for i, lane in enumerate(world.lanes)),
    ]
    for path, capacity in found:
        if capacity is not None:
            text = (
                "has no effect: robots pass through each other, as fewer than two have a radius and no policy is set;"
                f" add traffic: {{policy: {DEFAULT_POLICY}}}, or remove the capacity"
            )
            yield warning(path, text, capacity)
            return


def _check_starts(world: World, settings: ReserveSettings, lost: Lost) -> Iterator[Finding]:
    """Yield an error for each robot that starts on another one, or where the capacity is exceeded."""
    robots = {name: robot for name, robot in world.robots.items() if not components_lost(robot, name, lost)}
    starts = [start for name, robot in robots.items() if (start := _start(world, name, robot)) is not None]
    starts.sort(key=lambda start: start[0])
    if not starts:
        return
    rooms = _Rooms(world, settings)
    known = not lost.touches("waypoints", "lanes", "traffic")
    hint = "" if world.traffic.policy else " (the default; traffic: {policy: free} lets robots pass through each other)"
    widest = 2 * max((radius for _, radius, _ in starts), default=0.0)
    near: deque[tuple[Point, float, str]] = deque()
    for start in starts:
        point, radius, name = start
        while near and point[0] - near[0][0][0] > max(SAME_PLACE, widest):
            near.popleft()
        place, most = rooms.at(point) if known else ("", math.inf)
        message = ""
        for other_point, other_radius, other in near:
            room = max(SAME_PLACE, radius + other_radius)
            away = distance(point, other_point)
            if away < room and not (away <= SAME_PLACE and most > 1):
                where = f"{away:.3g} from {other!r}" if away > SAME_PLACE else f"where {other!r} does"
                message = f"starts {where}; under {world.policy!r} keep {room:.3g} away{hint}"
        if not message and rooms.take(place) > most:
            message = f"is one robot too many on {place}, which has room for {most:g} under {world.policy!r}{hint}"
        if message:
            yield Finding(("robots", name, "at"), message, [*point])
        near.append(start)


class _Rooms:
    """The capacities of waypoints and lanes, and the numbers of robots that start there.

    Args:
        world: The world; unknown names are left out.
        settings: The settings of its traffic policy.
    """

    def __init__(self, world: World, settings: ReserveSettings) -> None:
        self._settings = settings
        self._taken: Counter[str] = Counter()
        points = world.points
        rooms = rooms_of_waypoints(world, settings.waypoint_capacity)
        self._waypoints = {point: (name, rooms[name]) for name, point in points.items()}
        self._world = world

    @cached_property
    def _lanes(self) -> LaneIndex:
        """The lanes, for robots that start off the waypoints."""
        return LaneIndex(self._world, known_lanes(self._world))

    def at(self, point: Point) -> tuple[str, float]:
        """Return the waypoint or lane at a point, and its capacity; an empty name and no limit off the lanes."""
        if point in self._waypoints:
            name, room = self._waypoints[point]
            return f"waypoint {name!r}", room
        for lane in map(self._lanes.lanes.__getitem__, self._lanes.lanes_at(point)):
            return f"lane {lane.from_}-{lane.to}", lane.capacity or self._settings.lane_capacity or math.inf
        return "", math.inf

    def take(self, place: str) -> int:
        """Count a robot at a part of the lanes, and return the new number."""
        self._taken[place] += 1
        return self._taken[place] if place else 0


def _start(world: World, name: str, robot: RobotSpec) -> tuple[Point, float, str] | None:
    """Return the start of a robot and its radius; None if it flies or the start is unknown."""
    base, point = known_start(world, robot)
    return (point, base.radius or 0.0, name) if base and point and not base.flies else None
