"""The checks of traffic: its policy, and who starts where."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

from pydantic import ValidationError

from hmrsim.geometry import SAME_PLACE, distance
from hmrsim.traffic import registry as policies
from hmrsim.world.explain import explain
from hmrsim.world.finding import Finding, instead
from hmrsim.world.model import Waypoint

if TYPE_CHECKING:
    from collections.abc import Iterator

    from hmrsim.geometry import Point
    from hmrsim.world.model import RobotSpec, World


def check_traffic(world: World) -> Iterator[Finding]:
    """Yield what is wrong with the traffic of a world."""
    policy = policies().get(world.traffic.policy)
    if policy is None:
        message = f"no traffic policy {world.traffic.policy!r}{instead(world.traffic.policy, policies())}"
        yield Finding(("traffic", "policy"), message, world.traffic.policy)
        return
    settings = world.traffic.model_dump()
    try:
        policy.settings.model_validate(settings)
    except ValidationError as error:
        for finding in explain(error, settings, policy.settings):
            yield Finding(("traffic", *finding.path), finding.message, finding.value)
    if policy.rule is not None:
        yield from _check_starts(world)


def _check_starts(world: World) -> Iterator[Finding]:
    """Yield the robots that start where another one is, but for places with room for several."""
    starts = [start for name, robot in world.robots.items() if (start := _start(world, name, robot)) is not None]
    starts.sort(key=lambda start: start[0][0])
    widest = 2 * max((radius for _, radius, _ in starts), default=0.0)
    near: deque[tuple[Point, float, str]] = deque()
    for start in starts:
        point, radius, name = start
        while near and point[0] - near[0][0][0] > max(SAME_PLACE, widest):
            near.popleft()
        for other_point, other_radius, other in near:
            room = max(SAME_PLACE, radius + other_radius)
            away = distance(point, other_point)
            if away < room and not (away <= SAME_PLACE and _room(world, point) > 1):
                message = f"starts {away:.3g} from {other!r}; under {world.traffic.policy!r} keep {room:g} away"
                yield Finding(("robots", name, "at"), message, [*point])
        near.append(start)


def _start(world: World, name: str, robot: RobotSpec) -> tuple[Point, float, str] | None:
    """Return where a robot starts, and its radius; nothing if it flies, or that can't be said."""
    try:
        base, point = world.robot_type(robot).base, world.point(robot.at)
    except KeyError:
        return None
    return None if base.flies else (point, base.radius or 0.0, name)


def _room(world: World, point: Point) -> float:
    """Return how many robots may be at a point by what is said of a waypoint or dock there."""
    said = [at.capacity or 1 for at in world.waypoints.values() if isinstance(at, Waypoint) and at.at == point]
    said += [dock.capacity for name, dock in world.docks.items() if world.dock_point(name) == point]
    return max(said, default=1)
