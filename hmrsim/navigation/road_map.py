"""The map of a world: its lanes, and the routes planned on them, shared between runs.

Worlds with the same map share it within a process, so that a run can use the routes planned in earlier ones. Nothing in
it depends on a run: what a run changes, such as which doors are closed, is in `hmrsim.navigation.graph`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING, Final

from hmrsim.navigation.adjacency import Durations
from hmrsim.navigation.cache import LruCache
from hmrsim.navigation.lanes import Lanes
from hmrsim.navigation.motion import Drives
from hmrsim.navigation.planner import Planner
from hmrsim.world.derived import Derived
from hmrsim.world.model import Door, World

if TYPE_CHECKING:
    from collections.abc import Sequence


_KEPT_MAPS = 4
"""Cached road maps; the least recently used one is dropped."""

_MOST_WAYPOINTS = 20_000
"""Waypoints of the largest cached map: some 10 MB, and as much again for routes."""

_KEPT_DRIVES = 1_024
"""Cached motions per map."""

_KEPT_PIECES = 200_000
"""Pieces of all cached motions together, if each leads over the whole map: some 100 MB."""

_KEPT_STREETS = 4
"""Sets of avoided ways with cached planners: policies take them from the map and their settings."""


class RoadMap:
    """The lanes of a map, and planners on them.

    Args:
        world: A world with the map; its other parts are ignored.

    Attributes:
        lanes: The lanes.
        drives: The motions of robots on the lanes.
    """

    def __init__(self, world: World) -> None:
        self.lanes = Lanes(world)
        self.drives = Drives(min(_KEPT_DRIVES, _KEPT_PIECES // max(1, len(self.lanes.ways.ends))))
        self._planners: LruCache[tuple[tuple[int, ...], float], Planners] = LruCache(_KEPT_STREETS)

    def planners(self, avoided: Sequence[int] = (), factor: float = 1.0) -> Planners:
        """Return the planners for which some ways count for so many times as long as they take."""
        key = (*avoided,), factor
        return self._planners.get(key, lambda: Planners(self.lanes, *key))


@dataclass(frozen=True)
class _Map:
    """The map of a world, compared by its text, which distinguishes equal numbers such as 0 and -0.

    Attributes:
        world: A world with the map only, so that nothing else can get into the cache.
    """

    text: str
    world: World = field(compare=False)


def road_map_of(world: World) -> RoadMap:
    """Return the road map of a world, which worlds with the same map share."""
    return _ROAD_MAPS(world) if len(world.waypoints) <= _MOST_WAYPOINTS else RoadMap(_bare(world))


def _bare(world: World) -> World:
    """Return a world with the map of another one and nothing else."""
    doors = {name: Door.model_construct(at=door.at) for name, door in world.doors.items()}
    return World.model_construct(
        bounds=world.bounds,
        waypoints=world.waypoints,
        lanes=world.lanes,
        walls=world.walls,
        doors=doors,
        lifts=world.lifts,
    )


def _cached(world: World) -> RoadMap:
    bare = _bare(world)
    return _road_map(_Map(bare.model_dump_json(exclude_unset=True), bare))


@lru_cache(_KEPT_MAPS)
def _road_map(at: _Map) -> RoadMap:
    return RoadMap(at.world)


_ROAD_MAPS: Final = Derived(_cached, "bounds", "waypoints", "lanes", "walls", "doors", "lifts")


_KEPT_PLANNERS = 16
"""Cached planners, one for each set of closed lanes; the least recently used one is dropped."""

Lane = tuple[str, str]
"""A lane in one direction, by the waypoints where it begins and ends."""


class Planners:
    """Planners on the lanes of a map.

    Args:
        lanes: The lanes.
        avoided: The numbers of ways that count for longer.
        factor: How many times as long these count for.

    Attributes:
        durations: How long each way counts for.
    """

    def __init__(self, lanes: Lanes, avoided: Sequence[int] = (), factor: float = 1.0) -> None:
        self._lanes = lanes
        self.durations = Durations(lanes.ways, avoided, factor)
        self._kept: LruCache[frozenset[Lane], Planner] = LruCache(_KEPT_PLANNERS)

    def without(self, closed: frozenset[Lane]) -> Planner:
        """Return the planner that takes none of some lanes."""
        return self._kept.get(closed, lambda: self._planner(closed))

    def _planner(self, closed: frozenset[Lane]) -> Planner:
        numbers = self._lanes.numbers
        return Planner(self._lanes, self.durations, {numbers[lane] for lane in closed if lane in numbers})
