"""The moves of the robots of a world by class, and the relaxed problem derived from them."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from hmrsim.random_fleets.layers import Layer
from hmrsim.random_fleets.relaxation import Relaxation
from hmrsim.traffic.nearness import touch

if TYPE_CHECKING:
    from hmrsim.random_fleets.places import Move, Places
    from hmrsim.random_fleets.relaxation import Work

Blocks = tuple[tuple[int, int], ...]
"""Places, and the classes of robots that block a move from there, as bits."""

State = tuple[int, tuple[int, ...]]
"""The place of the robot with the order, and the sorted codes (place times classes, plus class) of the others."""


@dataclass
class Lanes:
    """The places of robots, and the moves between them.

    Attributes:
        moves: By class and place, where a robot can go, and what blocks that.
        rings: The places of each ring that robots can drive at once.
        room: By place, how many robots may be there.
        is_waypoint: By place, whether it is a waypoint.
        work: The number of states of relaxed problems that may still be visited.
    """

    moves: list[list[list[tuple[int, Blocks]]]]
    rings: list[tuple[int, ...]]
    room: list[float]
    is_waypoint: list[bool]
    work: Work
    _relaxations: dict[object, Relaxation] = field(default_factory=dict)

    @property
    def count(self) -> int:
        """The number of classes of robots."""
        return len(self.moves)

    def without(self, fixed: Iterable[tuple[int, int]]) -> Lanes:
        """Return the lanes that are free while robots of these classes stand at some places."""
        signs, room = dict[int, int](), [*self.room]
        for place, kind in fixed:
            signs[place] = signs.get(place, 0) | 1 << kind
            room[place] -= 1
        moves = [
            [
                [
                    (end, blocks)
                    for end, blocks in out
                    if room[end] >= 1 and not any(kinds & signs.get(at, 0) for at, kinds in blocks if at != start)
                ]
                for start, out in enumerate(row)
            ]
            for row in self.moves
        ]
        rings = [ring for ring in self.rings if not any(place in signs for place in ring)]
        return Lanes(moves, rings, room, self.is_waypoint, self.work)

    def relaxation(self, kind: int, target: int, state: State) -> Relaxation:
        """Return the relaxed problem for a robot of a class with a target, from the current configuration."""
        taken = {code // self.count: code % self.count for code in state[1] if not self.is_waypoint[code // self.count]}
        here = -1 if self.is_waypoint[state[0]] else state[0]
        waypoints = len(state[1]) - len(taken)
        key = kind, here, target, waypoints, tuple(sorted(taken.items()))
        if key not in self._relaxations:
            many = len(state[1]) + 1

            def layer(left: tuple[int, ...]) -> Layer:
                return self._layer(kind, (here, target), {spot: taken[spot] for spot in left}, many)

            self._relaxations[key] = Relaxation(layer, target, [*taken], waypoints, self.work)
        return self._relaxations[key]

    def is_in_the_way(self, code: int, ends: Collection[int]) -> bool:
        """Return whether a robot blocks, or may block, moves between waypoints and some further places."""
        spot, kind = divmod(code, self.count)
        return (
            self.is_waypoint[spot]
            or spot in ends
            or any(
                spot != start and any(at == spot and kinds >> kind & 1 for at, kinds in blocks)
                for moves in self.moves
                for start, out in enumerate(moves)
                if self.is_waypoint[start] or start in ends
                for end, blocks in out
                if self.is_waypoint[end] or end in ends
            )
        )

    def _layer(self, kind: int, ends: tuple[int, int], taken: Mapping[int, int], many: int) -> Layer:
        """Return the lanes while robots of these classes are at some spots."""
        is_waypoint, size = self.is_waypoint, len(self.room)
        signs = {spot: 1 << taken[spot] for spot in taken}
        ways: list[list[int]] = [[] for _ in range(size)]
        others: list[dict[int, None]] = [{} for _ in range(size)]
        exits: dict[int, dict[int, None]] = {spot: {} for spot in taken}
        for other, moves in enumerate(self.moves):
            for at, out in enumerate(moves):
                for end, blocks in out:
                    if any(number in signs and kinds & signs[number] and number != at for number, kinds in blocks):
                        continue
                    if at in taken:
                        if taken[at] == other and is_waypoint[end]:
                            exits[at][end] = None
                        continue
                    if other == kind and (is_waypoint[at] or at in ends) and (is_waypoint[end] or end in ends):
                        ways[at].append(end)
                    if is_waypoint[at] and is_waypoint[end]:
                        others[at][end] = None
        rooms = [int(min(room, many)) if is_waypoint[at] else 0 for at, room in enumerate(self.room)]
        return Layer(ways, [[*row] for row in others], rooms, {spot: [*row] for spot, row in exits.items()})


def lanes_of(places: Places, robots: Mapping[str, float], work: Work) -> tuple[Lanes, dict[str, int]]:
    """Return the lanes of a world, and the class of each robot.

    Args:
        places: The places and moves.
        robots: The radius of each robot.
        work: The number of states of relaxed problems that may be visited.
    """
    kinds = _classes(places, robots)
    members = [
        next(name for name in robots if kinds[name] == kind) for kind in range(1 + max(kinds.values(), default=-1))
    ]
    lanes = Lanes(
        [_moves_of(places, robots, member, members) for member in members],
        [tuple(move.start for move in ring) for ring in places.rings],
        [place.capacity for place in places.all],
        [place.waypoint != "" for place in places.all],
        work,
    )
    return lanes, kinds


def _classes(places: Places, robots: Mapping[str, float]) -> dict[str, int]:
    """Return the class of each robot; robots of a class can stand and drive in the same places."""
    moves = [move for out in places.moves for move in out]
    gaps = sorted({away for move in moves for _, away in move.near if away > 0.0})
    doors = sorted({tuple(sorted(move.doors)) for move in moves if move.doors is not None})
    radii = sorted({*robots.values()})
    numbers: dict[object, int] = {}
    classes = {}
    for name, radius in robots.items():
        sign = (
            tuple(name in allowed for allowed in doors),
            tuple(touch(away, radius + other) for away in gaps for other in radii),
        )
        classes[name] = numbers.setdefault(sign, len(numbers))
    return classes


def _moves_of(
    places: Places, robots: Mapping[str, float], name: str, members: Sequence[str]
) -> list[list[tuple[int, Blocks]]]:
    """Return the destinations by place, with the places that must be free of certain classes of robots."""
    radius, all_kinds = robots[name], (1 << len(members)) - 1

    def against(away: float) -> int:
        if away <= 0.0:
            return all_kinds
        kinds = (kind for kind, other in enumerate(members) if touch(away, radius + robots[other]))
        return sum(1 << kind for kind in kinds)

    def blocks(move: Move) -> Blocks:
        near = ((number, against(away)) for number, away in move.near)
        return tuple((number, kinds) for number, kinds in near if kinds)

    return [
        [(move.end, blocks(move)) for move in out if move.doors is None or name in move.doors] for out in places.moves
    ]
