"""The check that robots can leave where they start."""

from __future__ import annotations

import heapq
from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING

from hmrsim.diagnostics import Finding, warning
from hmrsim.geometry import SAME_PLACE, Obstacles, distance, foot
from hmrsim.world.network import nearest

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.world.model import World
    from hmrsim.world_checks.validation import Lost

_NEAREST = 24
"""Walls around a robot that are looked at first: those that wall it in are among them, if there are any."""

_MAX_COMPARISONS = 2_000_000
"""Lanes times walls that are looked at for all robots that do not see the nearest waypoint: some seconds."""


def check_walled_in(world: World, lost: Lost) -> Iterator[Finding]:
    """Yield a warning for each robot that gets on no lane from where it starts, or leaves its waypoint by none.

    Where there are no lanes robots drive straight, and nothing is said; nor of robots in an obstacle, which are told
    elsewhere.
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
    """Return where robots start that drive on lanes, by name; without those of which that can't be said."""
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
    """The lanes of a world, and what stands between them and points beside them."""

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
        """Return whether a straight line leads to a lane, or there is too much to look at; *waypoint* is the nearest.

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
    """Return whether a point is on a lane, or sees its foot on it, or where the shadow around that ends."""
    at = foot(point, *lane)
    if distance(point, at) <= SAME_PLACE:
        return True
    seen = (at, *obstacles.edges_of_shadow(point, *lane))
    return any(not obstacles.block(point, there) for there in seen)
