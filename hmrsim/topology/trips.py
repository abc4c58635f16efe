"""The trips between named places, as robots drive them."""

from __future__ import annotations

import random
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from hmrsim.errors import NoRoute
from hmrsim.navigation.graph import WaypointGraph
from hmrsim.world.model import Base

if TYPE_CHECKING:
    from hmrsim.world.model import World

MAX_STEPS: Final = 4_000_000
"""Maximum number of lanes that are searched for all destinations together: some seconds."""
MAX_PLACES: Final = 100
SEED: Final = 1


@dataclass(frozen=True)
class Trip:
    """A trip without turning and acceleration.

    Attributes:
        start: Name of the place or dock where it begins.
        goal: Likewise where it leads.
        length: In the world's unit.
        seconds: At the speed of these trips.
    """

    start: str
    goal: str
    length: float
    seconds: float


@dataclass(frozen=True)
class Trips:
    """The quickest trips between places and docks.

    Attributes:
        found: All of them, in order of the names.
        failed: Trips for which there is no route, and why.
        places: Between how many places they are.
        of: How many there are; more than *places* where they are too many, of which they are a sample that is always
            the same.
        speed: Of the robots, in the world's unit a second.
    """

    found: tuple[Trip, ...]
    failed: dict[tuple[str, str], str]
    places: int
    of: int
    speed: float


def speeds_of(world: World) -> dict[float, tuple[str, ...]]:
    """Return the speeds of robots that drive, with their types; that of most robots first.

    It is the speed of a robot without one, and no type, where no robot drives.
    """
    found: dict[float, list[str]] = {}
    for robot in world.robots.values():
        base = world.robot_type(robot).base
        if not base.flies:
            found.setdefault(world.speed(base), []).append(robot.type)
    ranked = sorted(found.items(), key=lambda one: (-len(one[1]), one[0]))
    return {speed: tuple(dict.fromkeys(types)) for speed, types in ranked} or {world.speed(Base()): ()}


def trips(world: World, speed: float) -> Trips:
    """Return the trips of robots of this greatest speed between all places and docks, or a sample of those."""
    names = sorted({*world.places, *world.docks})
    count = min(len(names), MAX_PLACES, MAX_STEPS // max(1, len(world.ways)))
    chosen = names if count == len(names) else sorted(random.Random(SEED).sample(names, count))
    if count < 2:  # noqa: PLR2004
        return Trips((), {}, 0, len(names), speed)
    found, failed = [], {}
    graph = WaypointGraph(world)
    for goal in chosen:
        for start in chosen:
            if start != goal:
                try:
                    found.append(_trip(graph, world, (start, goal), speed))
                except NoRoute as error:
                    failed[start, goal] = str(error)
    return Trips(tuple(sorted(found, key=lambda trip: (trip.start, trip.goal))), failed, count, len(names), speed)


def seconds_at(world: World, trips: Iterable[Trip], speed: float) -> dict[tuple[str, str], float]:
    """Return how long trips take robots of another speed, for which other ways may be quicker, by their ends."""
    graph = WaypointGraph(world)
    ends = [(trip.start, trip.goal) for trip in trips]
    return {pair: _trip(graph, world, pair, speed).seconds for pair in ends}


def _trip(graph: WaypointGraph, world: World, ends: tuple[str, str], speed: float) -> Trip:
    start, goal = map(world.point, ends)
    graph.check_start(start)
    route = graph.plan(start, goal, speed)
    return Trip(*ends, route.length, sum(leg.seconds(speed) for leg in route.legs))
