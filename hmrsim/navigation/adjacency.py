"""The adjacency of waypoints in arrays, since a grid has millions of ways, most of which are never driven."""

from __future__ import annotations

import math
from array import array
from bisect import bisect_left
from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import cached_property
from itertools import accumulate, chain, repeat
from typing import TYPE_CHECKING

from hmrsim.caches import LruCache
from hmrsim.world.model import PlainLanes

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.world.model import World


class Adjacency:
    """The lanes of a world in each direction in which they can be driven, and the rides in its lifts.

    Waypoints are numbered in order of name, ways by the names of where they begin, and then of where they end: numbers
    order as names do. Of two ways between the same waypoints the last one counts, rides after all lanes.

    Args:
        world: Where they are. Its names must have been checked.

    Attributes:
        names: Of the waypoints.
        points: Where they are.
        index: Their numbers, by name.
        first: By waypoint, the number of the first way that begins there; the others follow it. One more at the end.
        starts: By way, the waypoint where it begins.
        ends: By way, the waypoint where it ends.
        limits: By way, the most that may be driven there, for those that have a limit.
        rides: By way, the seconds that a lift takes, for those that are rides.
    """

    def __init__(self, world: World) -> None:
        self.names = sorted(world.waypoints)
        self.points: list[Point] = [world.points[name] for name in self.names]
        self.index = {name: number for number, name in enumerate(self.names)}
        limits: dict[tuple[int, int], float] = {}
        rides: dict[tuple[int, int], float] = {}
        rows = self._rows(world, limits, rides)
        self.first = array("i", accumulate(map(len, rows), initial=0))
        self.starts = array("i", chain.from_iterable(map(repeat, range(len(rows)), map(len, rows))))
        self.ends = array("i", chain.from_iterable(rows))
        self.limits = {self.number(*ends): limit for ends, limit in limits.items() if limit < math.inf}
        self.rides = {self.number(*ends): seconds for ends, seconds in rides.items()}

    def _rows(
        self, world: World, limits: dict[tuple[int, int], float], rides: dict[tuple[int, int], float]
    ) -> list[list[int]]:
        """Return the successors of each waypoint, in order, and record the attributes of the ways."""
        index = self.index
        rows: list[list[int]] = [[] for _ in self.names]
        lanes = world.lanes
        if isinstance(lanes, PlainLanes):
            number = [index[name] for name in lanes.pairs.names].__getitem__
            for a, b in zip(map(number, lanes.pairs.starts), map(number, lanes.pairs.ends), strict=True):
                rows[a].append(b)
                rows[b].append(a)
            lanes = ()
        for lane in lanes:
            start, end = index[lane.from_], index[lane.to]
            for a, b in ((start, end), (end, start))[: 1 if lane.one_way else 2]:
                rows[a].append(b)
                if lane.speed_limit or (a, b) in limits:
                    limits[a, b] = lane.speed_limit or math.inf
        for begin, stop, _, seconds in world.rides:
            a, b = index[begin], index[stop]
            rows[a].append(b)
            rides[a, b] = seconds
            limits.pop((a, b), None)
        for node, row in enumerate(rows):
            rows[node] = sorted({*row})
        return rows

    def number(self, start: int, end: int) -> int:
        """Return the number of the way between two waypoints, by their numbers; -1 if there is none."""
        last = self.first[start + 1]
        number = bisect_left(self.ends, end, self.first[start], last)
        return number if number < last and self.ends[number] == end else -1

    @cached_property
    def into(self) -> tuple[array[int], array[int]]:
        """The beginnings of each waypoint's incoming ways in a list of numbers, and this list."""
        counts = [0] * (len(self.names) + 1)
        for end in self.ends:
            counts[end + 1] += 1
        begins = array("i", accumulate(counts))
        free, numbers = begins.tolist(), array("i", repeat(0, len(self.ends)))
        for number, end in enumerate(self.ends):
            numbers[free[end]] = number
            free[end] += 1
        return begins, numbers

    @cached_property
    def forks(self) -> array[int]:
        """The waypoints from which several ways lead."""
        first = self.first
        return array("i", (node for node in range(len(self.names)) if first[node + 1] - first[node] > 1))

    @cached_property
    def tracks(self) -> tuple[array[int], array[int]]:
        """By way, the number of the track that it has in common with the way back; by track, its first way."""
        tracks, firsts = array("i", repeat(-1, len(self.ends))), array("i")
        first, ends = self.first, self.ends
        # Ways back begin at the waypoint where a way ends, in the order in which one comes to them here.
        back = first.tolist()
        for node in range(len(self.names)):
            for way in range(first[node], first[node + 1]):
                if tracks[way] >= 0:
                    continue
                tracks[way] = track = len(firsts)
                firsts.append(way)
                end = ends[way]
                other, last = back[end], first[end + 1]
                while other < last and ends[other] < node:
                    other += 1
                if other < last and ends[other] == node:
                    tracks[other] = track
                    other += 1
                back[end] = other
        return tracks, firsts

    def seconds(self, speed: float) -> array[float]:
        """Return how long each way takes a robot of this greatest speed, by its number, as `Leg.seconds` does."""
        at = self.points.__getitem__
        lengths = array("d", map(math.dist, map(at, self.starts), map(at, self.ends)))
        found = lengths if speed == 1.0 else array("d", (length / speed for length in lengths))
        for number, limit in self.limits.items():
            found[number] = math.dist(at(self.starts[number]), at(self.ends[number])) / min(speed, limit)
        for number, ride in self.rides.items():
            found[number] = ride
        return found


class Numbers(Mapping[tuple[str, str], int]):
    """The numbers of ways, by the names of the waypoints at their beginning and end."""

    def __init__(self, ways: Adjacency) -> None:
        self._ways = ways

    def __getitem__(self, lane: tuple[str, str]) -> int:
        """Return the number of a way."""
        start, end = lane
        number = self._ways.number(self._ways.index[start], self._ways.index[end])
        if number < 0:
            raise KeyError(lane)
        return number

    def __iter__(self) -> Iterator[tuple[str, str]]:
        """Yield all ways in order."""
        name = self._ways.names.__getitem__
        return zip(map(name, self._ways.starts), map(name, self._ways.ends), strict=True)

    def __len__(self) -> int:
        """Return how many ways there are."""
        return len(self._ways.ends)


_KEPT_SPEEDS = 16
"""Speeds for which the durations of all ways are cached."""


class Durations:
    """The seconds that ways count in planning: their travel times, or multiples for ways to avoid.

    Args:
        ways: The ways.
        avoided: The numbers of the avoided ones.
        factor: How many times as long these count for.
    """

    def __init__(self, ways: Adjacency, avoided: Sequence[int] = (), factor: float = 1.0) -> None:
        self._ways = ways
        self._avoided, self._factor = avoided, factor
        self._kept: LruCache[float, array[float]] = LruCache(_KEPT_SPEEDS)

    def at(self, speed: float) -> array[float]:
        """Return how long each way counts for a robot of this greatest speed, by its number."""
        return self._kept.get(speed, lambda: self._counted(speed))

    def without(self, closed: Collection[int], speed: float) -> array[float]:
        """Return the same where some ways are closed: these take infinitely long."""
        seconds = self.at(speed)[:]
        for number in closed:
            seconds[number] = math.inf
        return seconds

    def _counted(self, speed: float) -> array[float]:
        seconds = self._ways.seconds(speed)
        for number in self._avoided:
            seconds[number] *= self._factor
        return seconds
