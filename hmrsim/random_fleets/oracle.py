"""An oracle that decides whether a fleet can serve its orders, by a search over configurations of robots.

One robot moves at a time along a lane, or all robots of a ring at once. Robots keep apart wherever they stand or
drive; doors and lifts let them pass, doors only those for which they open. All robots but the one with the order are
interchangeable, as far as nothing tells them apart: footprints that matter, and doors that open for some.

Other robots make room at waypoints only, and those that start docked make none before they have had an order, as
under the traffic policies.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal, NamedTuple

from hmrsim.engine.chance import Chance
from hmrsim.geometry import SAME_PLACE, distance
from hmrsim.random_fleets.lanes import lanes_of
from hmrsim.random_fleets.places import Places
from hmrsim.random_fleets.relaxation import TooMuchWork, Work
from hmrsim.random_fleets.search import Distances, Search

if TYPE_CHECKING:
    from hmrsim.random_fleets.lanes import Lanes
    from hmrsim.random_fleets.search import Step
    from hmrsim.world.model import Demand, World

MAX_STATES = 10_000
"""Maximum configurations expanded by one search: a second or two."""

_SEARCHES = 4
"""Maximum of all searches of a fleet together, as a multiple: about 10 s."""

_MOST_WORK = 700_000
"""Maximum states of the relaxed problem for all searches of a fleet together: about 10 s."""


@dataclass(frozen=True)
class Verdict:
    """The oracle's verdict on a world.

    Attributes:
        answer: Whether its orders can be served; unknown if a search was given up.
        moves: Moves of the plan for all orders; 0 without one.
        states: How many configurations were expanded.
        why: The order that can't be served, or the search that was given up.
    """

    answer: Literal["solvable", "unsolvable", "unknown"]
    moves: int = 0
    states: int = 0
    why: str = ""


class Order(NamedTuple):
    """An order of the demand, with its time in seconds."""

    at: float
    name: str
    start: str
    end: str
    weight: float


def orders_of(world: World) -> list[Order]:
    """Return the orders that a simulation of a world will place, in order; demands without *count* have none."""
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
    """Return whether all orders of a world can be served one after the other.

    Args:
        world: Its names must have been checked.
        any_robot: Whether it is enough that one robot can serve an order; if not, each robot that lifts the item has
            to be able to get to where it is and where it has to be, so that a dispatcher may choose any.
        max_states: Configurations that each search expands before it is given up.
    """
    fleet = _Fleet(world, max_states)
    verdict = fleet.serve_all()
    if verdict.answer == "unsolvable" and fleet.docked:
        free = _Fleet(world, max_states, docked_stay=False).serve_all()
        if free.answer != "unsolvable":
            # An order for a docked robot may help.
            return replace(verdict, answer="unknown", why=f"{verdict.why}, while docked robots stay")
    if any_robot or verdict.answer != "solvable":
        return verdict
    return fleet.reach_all(verdict.moves)


def reaches(world: World, robot: str, place: str, *, max_states: int = MAX_STATES) -> bool | None:
    """Return whether a robot can reach a place from its start, or None if the search was given up.

    Args:
        world: Its names must have been checked.
        robot: The robot's name.
        place: The name of a place or waypoint.
        max_states: Configurations that the search expands before it is given up.
    """
    return _Fleet(world, max_states, places=[place]).reaches(robot, place)


class _Fleet:
    """The robots of a world and their places.

    Args:
        max_states: Configurations that each search expands before it is given up.
        docked_stay: Whether robots that start docked make no room.
        places: Where robots are sent beside the places of orders.

    Attributes:
        docked: The robots that start docked, and make no room.
    """

    def __init__(self, world: World, max_states: int, *, docked_stay: bool = True, places: Sequence[str] = ()) -> None:
        self._world = world
        self._max_states = max_states
        self._states = 0
        names = [name for name in world.robots if not world.robot_type(world.robots[name]).base.flies]
        self._orders = orders_of(world)
        starts = [world.point(world.robots[name].at) for name in names]
        names_of_ends = [*(name for order in self._orders for name in (order.start, order.end)), *places]
        ends = [*map(world.point, names_of_ends)]
        self.places = Places(world, [*starts, *ends])
        self._at: dict[str, int] = {name: self._number(point) for name, point in zip(names, starts, strict=True)}
        self.docked = [name for name in names if docked_stay and _starts_docked(world, name)]
        radii = {name: world.robot_type(world.robots[name]).base.radius or 0.0 for name in names}
        self._lanes, self._kinds = lanes_of(self.places, radii, Work(_MOST_WORK))
        self._left: dict[tuple[tuple[int, int], ...], Lanes] = {(): self._lanes}

    def _number(self, point: tuple[float, float]) -> int:
        number = self.places.number(point)
        if number is None:
            raise AssertionError
        return number

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
        """Return the verdict for an order that can't be served after others, which might have another plan."""
        served = self._serve(order, dict(self._at))
        if isinstance(served, Verdict) and served.answer == "unsolvable":
            return served
        return Verdict("unknown", 0, self._states, f"{verdict.why}, after the orders before it")

    def _serve(self, order: Order, at: Mapping[str, int]) -> tuple[dict[str, int], int] | Verdict:
        """Return the places of the robots after an order, and the number of moves."""
        start, end = (self._number(self._world.point(name)) for name in (order.start, order.end))
        away = Distances(self._lanes, start)
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
        """Return whether each robot can reach all places of the orders that it can carry, from its start."""
        wanted: dict[tuple[str, str], None] = {}
        for order in self._orders:
            for name in self._at:
                if lifts(self._world, name, order.weight):
                    wanted[name, order.start] = wanted[name, order.end] = None
        for name, place in wanted:
            reached = self.reaches(name, place)
            if reached is None:
                return Verdict("unknown", 0, self._states, f"gave up on {name} to {place}")
            if not reached:
                return Verdict("unsolvable", 0, self._states, f"{name} can't get to {place}")
        return Verdict("solvable", moves, self._states)

    def reaches(self, name: str, place: str) -> bool | None:
        """Return whether a robot can reach a place from its start, or None if that is unknown."""
        steps = self._search(self._at, name, self._number(self._world.point(place)), self._max_states)
        return None if steps is None else steps is not False

    def _search(
        self, at: Mapping[str, int], name: str, target: int, max_states: int
    ) -> list[list[Step]] | Literal[False] | None:
        """Return the steps that bring a robot to a place, False if there are none, or None if that is unknown."""
        docked = [other for other in self.docked if other != name and at[other] == self._at[other]]
        lanes = self._without(tuple(sorted((at[other], self._kinds[other]) for other in docked)))
        codes = (at[other] * lanes.count + self._kinds[other] for other in at if other != name and other not in docked)
        spots = {at[name]: None, target: None}
        spots |= {place: None for other, place in at.items() if not lanes.is_waypoint[place]}
        # The others stay where they are.
        others = tuple(sorted(code for code in codes if lanes.is_in_the_way(code, spots)))
        most = min(max_states, _SEARCHES * self._max_states - self._states)
        search = Search(lanes, self._kinds[name], target, most)
        try:
            steps = search.run((at[name], others))
        except TooMuchWork:
            steps = None
        self._states += search.expanded
        return steps

    def _without(self, docked: tuple[tuple[int, int], ...]) -> Lanes:
        """Return the lanes that are free while robots are docked."""
        if docked not in self._left:
            self._left[docked] = self._lanes.without(docked)
        return self._left[docked]

    def _apply(self, at: dict[str, int], name: str, steps: Sequence[Sequence[Step]]) -> int:
        """Execute the moves of a plan, and return their number."""
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


def _starts_docked(world: World, robot: str) -> bool:
    start, names = world.point(world.robots[robot].at), {robot, world.robots[robot].type}
    return any(
        distance(world.dock_point(name), start) <= SAME_PLACE
        for name, dock in world.docks.items()
        if dock.reserved_for is None or names & {*dock.reserved_for}
    )
