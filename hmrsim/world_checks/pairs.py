"""The limit of worlds that clients send: the number of pairs of parts compared to check and start a world."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Final

from hmrsim.diagnostics import Finding
from hmrsim.geometry import SAME_PLACE, Obstacles, distance, foot
from hmrsim.traffic.nearness import comparisons, widest
from hmrsim.traffic.policies import registry as policies
from hmrsim.world_checks.lanes import known_lanes, lane_ends

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.world.model import World

MAX_PAIRS: Final = 4_000_000
"""Maximum number of pairs in a client's world: a few seconds, in which other clients wait."""

_SLOW: Final = 5
"""The weight of slower pairs, which are those with lanes."""

_HIDDEN: Final = 10
"""The weight of a lane that a dock does not see, in walls."""


def check_pairs(world: World) -> Iterator[Finding]:
    """Yield an error if the parts of a world form more pairs than a client's world may."""
    counts = {
        "robots with walls": len(world.robots) * len(world.sides),
        "robots with docks": len(world.robots) * len(world.docks),
        "robots with doors": len(world.robots) * len(world.doors),
        "doors with lanes": _SLOW * len(world.doors) * len(world.lanes),
        "docks beside lanes with lanes": _SLOW * len(_beside(world)) * len(world.lanes),
        "robots with settings of their types": _settings(world),
        "starts of robots with each other": _starts(world),
        "robots beside lanes with these and with lanes": _standing(world),
        "lanes and waypoints with each other": _SLOW * _slots(world),
    }
    if sum(counts.values()) <= MAX_PAIRS:
        counts["robots in obstacles with lanes"] = _inside(world) * len(world.lanes)
        counts["walls with lanes that docks may not see"] = _hidden(world)
    total = sum(counts.values())
    if total > MAX_PAIRS:
        most = max(counts, key=counts.__getitem__)
        text = (
            f"is too large to be sent by a client: {total:,} pairs would be compared, {counts[most]:,} of them {most},"
            f" and the limit is {MAX_PAIRS:,}; start a simulator with it as a file"
        )
        yield Finding((), text, total)


def _settings(world: World) -> int:
    """Return the number of values that all robots have from their types."""
    sizes = {name: _size(kind.components) for name, kind in world.robot_types.items()}
    return sum(sizes.get(robot.type, 0) for robot in world.robots.values())


def _size(value: Any) -> int:
    """Return the number of values in a value."""
    parts = value.values() if isinstance(value, dict) else value if isinstance(value, list | tuple) else ()
    return 1 + sum(map(_size, parts))


def _beside(world: World) -> list[Point]:
    """Return the points of docks that are not at the end of a lane."""
    ends, beside = {end for lane in lane_ends(world) for end in lane}, []
    for name in world.docks:
        try:
            point = world.dock_point(name)
        except KeyError:
            continue
        if point not in ends:
            beside.append(point)
    return beside


def _inside(world: World) -> int:
    """Return the number of robots that start inside an obstacle, where they must be on a lane."""
    solids = Obstacles([], world.solids)
    return sum(map(solids.occupy, _starting(world)))


def _starting(world: World) -> Iterator[Point]:
    """Yield the known starts of robots."""
    starts = (world.find(robot.at) for robot in world.robots.values())
    return (point for point in starts if point is not None)


def _hidden(world: World) -> int:
    """Return the cost of finding a visible lane for each dock beside the lanes, or a number above the limit."""
    sides = len(world.sides) + len(world.doors)
    obstacles = world.obstacles(doors=True)
    count, lanes = 0, lane_ends(world)
    for point in _beside(world) if sides else ():
        for at in sorted((foot(point, *lane) for lane in lanes), key=lambda at: distance(point, at)):
            count += _SLOW * (sides + _HIDDEN)
            if count > MAX_PAIRS or not obstacles.block(point, at):
                break
    return count


def _reserves(world: World) -> bool:
    policy = policies().get(world.policy)
    return policy is not None and policy.rule is not None


def _starts(world: World) -> int:
    """Return the number of pairs of robots that start close enough in x to be compared."""
    if not _reserves(world):
        return 0
    xs = sorted(x for x, _ in _starting(world))
    reach = max(SAME_PLACE, widest(world))
    return sum(i - bisect_left(xs, x - reach) for i, x in enumerate(xs))


def _standing(world: World) -> int:
    """Return the cost of robots that start off the ends of lanes, in pairs."""
    if not _reserves(world):
        return 0
    lanes = lane_ends(world)
    ends = {end for lane in lanes for end in lane}
    count = sum(point not in ends for point in _starting(world))
    return count * (count + len(lanes)) // 2


def _slots(world: World) -> int:
    """Return the number of pairs of lanes and waypoints that are compared to find those that exclude each other."""
    if not _reserves(world):
        return 0
    number = {name: i for i, name in enumerate(world.points)}
    tracks = dict.fromkeys(
        frozenset((number[lane.from_], number[lane.to])) for lane in known_lanes(world) if lane.from_ != lane.to
    )
    ends = [*((i, i) for i in number.values()), *((min(track), max(track)) for track in tracks)]
    return comparisons([*world.points.values()], dict(enumerate(ends)), widest(world))
