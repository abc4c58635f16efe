"""An oracle that says whether a fleet can serve its orders: a search over configurations of robots.

One robot moves at a time along a lane, or all robots of a ring at once. Robots keep apart wherever they stand or
drive; doors and lifts let them pass, doors only those for which they open. All robots but the one with the order are
interchangeable, as far as nothing tells them apart: footprints that matter, and doors that open for some.
"""

from __future__ import annotations

import heapq
import math
from collections import deque
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, NamedTuple

from hmrsim.engine.chance import Chance
from hmrsim.random_fleets.places import Move, Places
from hmrsim.random_fleets.relaxation import Layer, Relaxation, TooMuchWork, Work
from hmrsim.traffic.policies._nearness import touch

if TYPE_CHECKING:
    from hmrsim.world.model import Demand, World

MAX_STATES = 10_000
"""Configurations that one search expands before it is given up: a second or two."""

_SEARCHES = 4
"""All searches of a fleet together expand at most so many times that number: 10 s or so."""

_MOST_WORK = 700_000
"""States of the easier problem that all searches of a fleet together look at: 10 s or so."""

_WEIGHT = 3
"""How much the way that is left counts against the moves made so far: plans are found soon, and not the shortest."""

_LEAP = 100
"""How many moves of others count as much as one move of the easier problem: more than there ever are before one."""

_SHARE = 4
"""One in so many expansions is complete; the others leave out the moves of robots that are in nobody's way."""

_MAX_HOLES = 8
"""Free places into which a robot in the way is pushed, at most."""


@dataclass(frozen=True)
class Verdict:
    """What the oracle says of a world.

    Attributes:
        answer: Whether its orders can be served; unknown if a search was given up.
        moves: Moves of the plan for all orders; 0 without one.
        states: How many configurations were expanded.
        why: What can't be done, or was given up.
    """

    answer: Literal["solvable", "unsolvable", "unknown"]
    moves: int = 0
    states: int = 0
    why: str = ""


class Order(NamedTuple):
    """An order of the demand, with when it comes, in seconds."""

    at: float
    name: str
    start: str
    end: str
    weight: float


def orders_of(world: World) -> list[Order]:
    """Return the orders that a simulation of a world will place, in order; a demand without *count* has none."""
    chance = Chance()
    chance.begin(world.seed)
    return sorted(order for spec in world.demand for order in _orders(chance, spec))


def _orders(chance: Chance, spec: Demand) -> Iterator[Order]:
    now = 0.0
    for number in range(1, (spec.count or 0) + 1):
        first = number == 1 and spec.first is not None
        value, use = (spec.first, "first") if first and spec.first is not None else (spec.arrives, "arrives")
        now += chance.drawn(value, spec.name, use, number)
        start = spec.at[chance.choose(len(spec.at), spec.name, "at", number)]
        end = spec.to[chance.choose(len(spec.to), spec.name, "to", number)]
        yield Order(now, f"{spec.name}_{number}", start, end, spec.weight)


def lifts(world: World, robot: str, weight: float) -> bool:
    """Return whether a robot can carry an item of a weight, in kg."""
    claw = world.robot_type(world.robots[robot]).components.get("claw")
    if claw is None:
        return False
    most = claw.get("max_weight")
    return most is None or weight <= float(most)


def solve(world: World, *, any_robot: bool = True, max_states: int = MAX_STATES) -> Verdict:
    """Return whether all orders of a world can be served, one after the other.

    Args:
        world: Its names must have been checked.
        any_robot: Whether it is enough that one robot can serve an order; if not, each robot that lifts the item has
            to be able to get to where it is and where it has to be, so that a dispatcher may choose any.
        max_states: Configurations that each search expands before it is given up.
    """
    fleet = _Fleet(world, max_states)
    verdict = fleet.serve_all()
    if any_robot or verdict.answer != "solvable":
        return verdict
    return fleet.reach_all(verdict.moves)


class _Step(NamedTuple):
    """One robot's part of a step: from where to where, and its class."""

    start: int
    end: int
    kind: int


_State = tuple[int, tuple[int, ...]]
"""Where the robot with the order is, and the sorted codes of the others: place times classes, plus class."""


class _Fleet:
    """The robots of a world and the places where they are.

    Args:
        max_states: Configurations that each search expands before it is given up.
    """

    def __init__(self, world: World, max_states: int) -> None:
        self._world = world
        self._max_states = max_states
        self._states = 0
        names = [name for name in world.robots if not world.robot_type(world.robots[name]).base.flies]
        self._orders = orders_of(world)
        starts = [world.point(world.robots[name].at) for name in names]
        ends = [world.point(name) for order in self._orders for name in (order.start, order.end)]
        self.places = Places(world, [*starts, *ends])
        self._at: dict[str, int] = {name: self._number(point) for name, point in zip(names, starts, strict=True)}
        self._kinds = self._classes(names)
        self.count = 1 + max(self._kinds.values(), default=0)
        members = [next(name for name in names if self._kinds[name] == kind) for kind in range(self.count)]
        self.moves = [self._moves_of(member, members) for member in members]
        self.rings = [tuple(move.start for move in ring) for ring in self.places.rings]
        self.room = [place.room for place in self.places.all]
        self.is_waypoint = [place.waypoint != "" for place in self.places.all]
        self._relaxations: dict[object, Relaxation] = {}
        self._work = Work(_MOST_WORK)

    def _number(self, point: tuple[float, float]) -> int:
        number = self.places.number(point)
        if number is None:
            raise AssertionError
        return number

    def _radius(self, name: str) -> float:
        return self._world.robot_type(self._world.robots[name]).base.radius or 0.0

    def _classes(self, names: Sequence[str]) -> dict[str, int]:
        """Return the class of each robot; those of one class can stand and drive in the same places."""
        moves = [move for out in self.places.moves for move in out]
        gaps = sorted({away for move in moves for _, away in move.near if away > 0.0})
        doors = sorted({tuple(sorted(move.doors)) for move in moves if move.doors is not None})
        radii = sorted({self._radius(name) for name in names})
        numbers: dict[object, int] = {}
        classes = {}
        for name in names:
            radius = self._radius(name)
            sign = (
                tuple(name in allowed for allowed in doors),
                tuple(touch(away, radius + other) for away in gaps for other in radii),
            )
            classes[name] = numbers.setdefault(sign, len(numbers))
        return classes

    def _moves_of(self, name: str, members: Sequence[str]) -> list[list[tuple[int, tuple[tuple[int, int], ...]]]]:
        """Return by place where a robot can go, and which classes of robots must not be at which places then."""
        radius, all_kinds = self._radius(name), (1 << len(members)) - 1

        def against(away: float) -> int:
            if away <= 0.0:
                return all_kinds
            kinds = (kind for kind, other in enumerate(members) if touch(away, radius + self._radius(other)))
            return sum(1 << kind for kind in kinds)

        def blocks(move: Move) -> tuple[tuple[int, int], ...]:
            near = ((number, against(away)) for number, away in move.near)
            return tuple((number, kinds) for number, kinds in near if kinds)

        return [
            [(move.end, blocks(move)) for move in out if move.doors is None or name in move.doors]
            for out in self.places.moves
        ]

    def relaxation(self, kind: int, target: int, state: _State) -> Relaxation:
        """Return the easier problem for a robot of a class that goes to a place, from where it and others are."""
        taken = {code // self.count: code % self.count for code in state[1] if not self.is_waypoint[code // self.count]}
        here = -1 if self.is_waypoint[state[0]] else state[0]
        waypoints = len(state[1]) - len(taken)
        key = kind, here, target, waypoints, tuple(sorted(taken.items()))
        if key not in self._relaxations:
            many = len(state[1]) + 1

            def layer(left: tuple[int, ...]) -> Layer:
                return self._layer(kind, (here, target), {spot: taken[spot] for spot in left}, many)

            self._relaxations[key] = Relaxation(layer, target, [*taken], waypoints, self._work)
        return self._relaxations[key]

    def _is_in_the_way(self, code: int, ends: Collection[int]) -> bool:
        """Return whether a robot keeps others from driving between waypoints and some more places, or may do so."""
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

    def serve_all(self) -> Verdict:
        """Return whether the orders can be served one after the other, each by any robot."""
        at, moves = dict(self._at), 0
        for order in self._orders:
            served = self._serve(order, at)
            if isinstance(served, Verdict):
                if served.answer == "unsolvable" and at != self._at:
                    served = self._alone(order, served)
                return served
            at, more = served
            moves += more
        return Verdict("solvable", moves, self._states)

    def _alone(self, order: Order, verdict: Verdict) -> Verdict:
        """Return the verdict of an order that can't be served after others: there may be another plan for those."""
        served = self._serve(order, dict(self._at))
        if isinstance(served, Verdict) and served.answer == "unsolvable":
            return served
        return Verdict("unknown", 0, self._states, f"{verdict.why}, after the orders before it")

    def _serve(self, order: Order, at: Mapping[str, int]) -> tuple[dict[str, int], int] | Verdict:
        """Return where the robots are after an order, and how many moves that takes."""
        start, end = (self._number(self._world.point(name)) for name in (order.start, order.end))
        away = _Distances(self, start)
        capable = [name for name in at if lifts(self._world, name, order.weight)]
        capable.sort(key=lambda name: away.of(self._kinds[name], at[name]))
        unknown = False
        # Another robot is often the quicker one to find a plan for.
        for max_states in (self._max_states // 20, self._max_states):
            unknown = False
            for name in capable:
                total, now = 0, dict(at)
                for target in (start, end):
                    steps = self._search(now, name, target, max_states)
                    if not isinstance(steps, list):
                        unknown |= steps is None
                        break
                    total += self._apply(now, name, steps)
                else:
                    return now, total
            if not unknown:
                break
        why = f"{order.name} from {order.start} to {order.end}"
        if unknown:
            return Verdict("unknown", 0, self._states, f"gave up on {why}")
        return Verdict("unsolvable", 0, self._states, f"no robot can serve {why}")

    def reach_all(self, moves: int) -> Verdict:
        """Return whether each robot can get to all places of the orders that it can carry, from where it starts."""
        wanted: dict[tuple[str, str], None] = {}
        for order in self._orders:
            for name in self._at:
                if lifts(self._world, name, order.weight):
                    wanted[name, order.start] = wanted[name, order.end] = None
        for name, place in wanted:
            steps = self._search(self._at, name, self._number(self._world.point(place)), self._max_states)
            if steps is False:
                return Verdict("unsolvable", 0, self._states, f"{name} can't get to {place}")
            if steps is None:
                return Verdict("unknown", 0, self._states, f"gave up on {name} to {place}")
        return Verdict("solvable", moves, self._states)

    def _search(
        self, at: Mapping[str, int], name: str, target: int, max_states: int
    ) -> list[list[_Step]] | Literal[False] | None:
        """Return the steps that bring a robot to a place; False if there are none, None if that is unknown."""
        codes = sorted(at[other] * self.count + self._kinds[other] for other in at if other != name)
        spots = {at[name]: None, target: None}
        spots |= {code // self.count: None for code in codes if not self.is_waypoint[code // self.count]}
        # The others stay where they are.
        others = tuple(code for code in codes if self._is_in_the_way(code, spots))
        most = min(max_states, _SEARCHES * self._max_states - self._states)
        search = _Search(self, self._kinds[name], target, most)
        try:
            steps = search.run((at[name], others))
        except TooMuchWork:
            steps = None
        self._states += search.expanded
        return steps

    def _apply(self, at: dict[str, int], name: str, steps: Sequence[Sequence[_Step]]) -> int:
        """Move the robots of a plan; return how many moves that were."""
        for step in steps:
            moved: dict[str, int] = {}
            for start, end, kind in step:
                if kind < 0:
                    moved[name] = end
                    continue
                there = (other for other in at if at[other] == start and other != name and other not in moved)
                moved[next(other for other in there if self._kinds[other] == kind)] = end
            at.update(moved)
        return sum(map(len, steps))


class _Distances:
    """How many moves it is to a place from everywhere, by class, where no robot is in the way."""

    def __init__(self, fleet: _Fleet, target: int) -> None:
        self._fleet = fleet
        self._target = target
        self._known: dict[int, list[float]] = {}

    def of(self, kind: int, place: int) -> float:
        """Return how far it is for a class from a place; infinite if no way leads there."""
        return self.all(kind)[place]

    def all(self, kind: int) -> list[float]:
        """Return how far it is for a class from each place."""
        if kind not in self._known:
            fleet, target = self._fleet, self._target
            into: list[list[int]] = [[] for _ in fleet.room]
            for start, out in enumerate(fleet.moves[kind]):
                for end, _ in out:
                    if fleet.is_waypoint[end] or end == target:
                        into[end].append(start)
            away = [math.inf] * len(into)
            away[target], todo = 0.0, deque([target])
            while todo:
                place = todo.popleft()
                for before in into[place]:
                    if away[before] == math.inf:
                        away[before] = away[place] + 1
                        todo.append(before)
            self._known[kind] = away
        return self._known[kind]


class _Search:
    """A best-first search for the steps that bring one robot to a place.

    Args:
        kind: The robot's class.
        target: The place. It alone may be off the waypoints: other robots leave such places, and do not come back.
    """

    def __init__(self, fleet: _Fleet, kind: int, target: int, max_states: int) -> None:
        self._fleet = fleet
        self._kind = kind
        self._target = target
        self._max_states = max_states
        self._away = _Distances(fleet, target).all(kind)
        self._relaxation: Relaxation | None = None
        self._before: dict[_State, tuple[_State, list[list[_Step]]] | None] = {}
        self._cost: dict[_State, int] = {}
        self._first: list[tuple[float, int, _State]] = []
        self._rest: list[tuple[float, int, _State]] = []
        self._number = 0
        self.expanded = 0
        self._counts: list[int] = []
        self._masks: list[int] = []

    def run(self, start: _State) -> list[list[_Step]] | Literal[False] | None:
        """Return the steps; False if there are none, None if too many configurations were expanded."""
        if self._away[start[0]] == math.inf:
            return False
        if start[0] == self._target:
            return []
        self._relaxation = self._fleet.relaxation(self._kind, self._target, start)
        self._before[start], self._cost[start] = None, 0
        self._push(start)
        while self._first or self._rest:
            if self.expanded >= self._max_states:
                return None
            self.expanded += 1
            complete = not self._first or (self._rest and self.expanded % _SHARE == 0)
            rank, _, state = heapq.heappop(self._rest if complete else self._first)
            self._look(state)
            found = self._complete_steps(state) if complete else self._promising_steps(state)
            for after, steps in found:
                if after in self._before:
                    continue
                self._before[after] = state, steps
                self._cost[after] = self._cost[state] + sum(map(len, steps))
                if after[0] == self._target:
                    return self._plan(after)
                self._push(after)
            if not complete:
                self._number += 1
                heapq.heappush(self._rest, (rank, self._number, state))
        return False

    def _push(self, state: _State) -> None:
        count = self._fleet.count
        if self._relaxation is None:
            raise AssertionError
        left, effort = self._relaxation.moves(state[0], [code // count for code in state[1]])
        if left == math.inf:
            return
        self._number += 1
        heapq.heappush(self._first, (self._cost[state] + _WEIGHT * (_LEAP * left + effort), self._number, state))

    def _plan(self, state: _State) -> list[list[_Step]]:
        steps: list[list[_Step]] = []
        before = self._before[state]
        while before is not None:
            state, more = before
            steps = [*more, *steps]
            before = self._before[state]
        return steps

    def _look(self, state: _State) -> None:
        """Count the robots at each place."""
        count = self._fleet.count
        counts, masks = [0] * len(self._fleet.room), [0] * len(self._fleet.room)
        counts[state[0]], masks[state[0]] = 1, 1 << self._kind
        for code in state[1]:
            place, kind = divmod(code, count)
            counts[place] += 1
            masks[place] |= 1 << kind
        self._counts, self._masks = counts, masks

    def _promising_steps(self, state: _State) -> Iterator[tuple[_State, list[list[_Step]]]]:
        """Yield what the robot can do, and how those in its way can make room by chains into free places."""
        fleet, (here, others) = self._fleet, state
        for end, blocks in fleet.moves[self._kind][here]:
            if not (fleet.is_waypoint[end] or end == self._target):
                continue
            blockers = [number for number, kinds in blocks if self._masks[number] & kinds]
            if self._counts[end] >= fleet.room[end]:
                blockers.append(end)
            if not blockers:
                yield (end, others), [[_Step(here, end, -1)]]
            elif self._away[end] < math.inf:
                for blocker in blockers:
                    yield from self._chains(state, blocker, end)
        yield from self._ring_steps(state)

    def _complete_steps(self, state: _State) -> Iterator[tuple[_State, list[list[_Step]]]]:
        """Yield the moves of all other robots to waypoints."""
        fleet, (here, others) = self._fleet, state
        before = -1
        for i, code in enumerate(others):
            if code == before:
                continue
            before = code
            place, kind = divmod(code, fleet.count)
            for end, blocks in fleet.moves[kind][place]:
                if fleet.is_waypoint[end] and self._is_open(end, blocks, self._counts, self._masks):
                    after = sorted((*others[:i], end * fleet.count + kind, *others[i + 1 :]))
                    yield (here, tuple(after)), [[_Step(place, end, kind)]]

    def _is_open(
        self, end: int, blocks: Sequence[tuple[int, int]], counts: Sequence[int], masks: Sequence[int]
    ) -> bool:
        return counts[end] < self._fleet.room[end] and not any(masks[number] & kinds for number, kinds in blocks)

    def _chains(self, state: _State, blocker: int, wanted: int) -> Iterator[tuple[_State, list[list[_Step]]]]:
        """Yield how the robot at a place moves on along waypoints into free ones; those on its way move before it."""
        fleet, here = self._fleet, state[0]
        if blocker == here:
            return
        kind = self._kind_at(blocker)
        came: dict[int, int] = {blocker: -1, here: -1}
        todo, holes = deque([blocker]), 0
        while todo and holes < _MAX_HOLES:
            place = todo.popleft()
            for end, _ in fleet.moves[kind][place]:
                if end in came or not fleet.is_waypoint[end]:
                    continue
                came[end] = place
                todo.append(end)
                if self._counts[end] < fleet.room[end] and end != wanted:
                    holes += 1
                    yield from self._shift(state, came, end)

    def _kind_at(self, place: int) -> int:
        """Return the class of a robot at a place."""
        mask = self._masks[place]
        return (mask & -mask).bit_length() - 1

    def _shift(self, state: _State, came: Mapping[int, int], hole: int) -> Iterator[tuple[_State, list[list[_Step]]]]:
        """Yield the configuration after the robots of a chain have moved on, if each of them can."""
        path = [hole]
        while came[path[-1]] >= 0:
            path.append(came[path[-1]])
        codes, steps, to = [*state[1]], list[list[_Step]](), 0
        for i in range(1, len(path)):
            code = self._code_at(path[i], codes)
            if code is None:
                continue
            # It drives from lane to lane to where the one before it was.
            for j in range(i, to, -1):
                kind = code % self._fleet.count
                if not self._can_move(state[0], codes, kind, path[j], path[j - 1]):
                    return
                codes.remove(code)
                code = path[j - 1] * self._fleet.count + kind
                codes.append(code)
                steps.append([_Step(path[j], path[j - 1], kind)])
            to = i
        yield (state[0], tuple(sorted(codes))), steps

    def _code_at(self, place: int, codes: Sequence[int]) -> int | None:
        return next((code for code in codes if code // self._fleet.count == place), None)

    def _can_move(self, here: int, codes: Sequence[int], kind: int, start: int, end: int) -> bool:
        """Return whether a robot of a class can move while the others are at these places."""
        fleet = self._fleet
        blocks = next((blocks for to, blocks in fleet.moves[kind][start] if to == end), None)
        if blocks is None or sum(code // fleet.count == end for code in codes) + (here == end) >= fleet.room[end]:
            return False
        around = dict(blocks)
        if around.get(here, 0) >> self._kind & 1:
            return False
        return not any(around.get(code // fleet.count, 0) >> code % fleet.count & 1 for code in codes)

    def _ring_steps(self, state: _State) -> Iterator[tuple[_State, list[list[_Step]]]]:
        """Yield the configurations after all robots of a full ring have moved on at once."""
        fleet, (here, others) = self._fleet, state
        for ring in fleet.rings:
            if any(self._counts[place] < fleet.room[place] for place in ring):
                continue
            steps, codes, place = [], [*others], here
            for start, end in zip(ring, (*ring[1:], ring[0]), strict=True):
                if start == here:
                    kind, place = self._kind, end
                    steps.append(_Step(start, end, -1))
                else:
                    kind = self._kind_at(start)
                    codes.remove(start * fleet.count + kind)
                    codes.append(end * fleet.count + kind)
                    steps.append(_Step(start, end, kind))
                blocks = next((blocks for to, blocks in fleet.moves[kind][start] if to == end), None)
                if blocks is None or any(self._masks[at] & kinds for at, kinds in blocks if at not in ring):
                    break
            else:
                yield (place, tuple(sorted(codes))), [steps]
