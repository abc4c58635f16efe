"""The checks of traffic: its policy, and the robots' start positions."""

from __future__ import annotations

import math
from collections import Counter, deque
from collections.abc import Iterator
from functools import cached_property
from typing import TYPE_CHECKING

from pydantic import ValidationError

from hmrsim.diagnostics import Finding, instead, warning
from hmrsim.documents.validation import explain
from hmrsim.geometry import SAME_PLACE, distance
from hmrsim.traffic.policies import registry as policies
from hmrsim.traffic.policies._nearness import rooms_of_waypoints
from hmrsim.traffic.policies.reserve import ReserveSettings
from hmrsim.world.model import DEFAULT_POLICY
from hmrsim.world_checks.lanes import LaneIndex, known_lanes

if TYPE_CHECKING:
    from hmrsim.diagnostics import Path
    from hmrsim.geometry import Point
    from hmrsim.world.model import RobotSpec, World
    from hmrsim.world_checks.validation import Lost


def check_traffic(world: World, lost: Lost | None = None) -> Iterator[Finding]:
    """Yield the errors and warnings of the traffic of a world.

    There are none under a default policy if parts of the world are lost: with them it could be another one.
    """
    by_default = world.traffic.policy is None
    if by_default and lost:
        return
    policy = policies().get(world.policy)
    if policy is None:
        message = f"no traffic policy {world.policy!r}{instead(world.policy, policies())}"
        yield Finding(("traffic", "policy"), message, world.policy)
        return
    said = world.traffic.model_dump()
    try:
        settings = policy.settings.model_validate(said)
    except ValidationError as error:
        hint = f" (the policy is {policy.name!r} by default; set another one)" if by_default else ""
        for finding in explain(error, said, policy.settings):
            yield Finding(("traffic", *finding.path), f"{finding.message}{hint}", finding.value)
        return
    if isinstance(settings, ReserveSettings):
        yield from _check_starts(world, settings)
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


def _check_starts(world: World, settings: ReserveSettings) -> Iterator[Finding]:
    """Yield an error for each robot that starts on another one, or where the capacity is exceeded."""
    starts = [start for name, robot in world.robots.items() if (start := _start(world, name, robot)) is not None]
    starts.sort(key=lambda start: start[0])
    if not starts:
        return
    rooms = _Rooms(world, settings)
    hint = "" if world.traffic.policy else " (the default; traffic: {policy: free} lets robots pass through each other)"
    widest = 2 * max((radius for _, radius, _ in starts), default=0.0)
    near: deque[tuple[Point, float, str]] = deque()
    for start in starts:
        point, radius, name = start
        while near and point[0] - near[0][0][0] > max(SAME_PLACE, widest):
            near.popleft()
        place, most = rooms.at(point)
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
        world: Where; names that make no sense are left out.
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
    try:
        base, point = world.robot_type(robot).base, world.point(robot.at)
    except KeyError:
        return None
    return None if base.flies else (point, base.radius or 0.0, name)
