"""The oracle says what an exhaustive search says, and is right about worlds made by hand."""

from __future__ import annotations

from collections import Counter, deque
from itertools import combinations, product
from math import dist

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from hmrsim.random_fleets.oracle import orders_of, reaches, solve
from hmrsim.random_fleets.places import Places
from hmrsim.simulation.simulator import Simulator
from hmrsim.traffic.nearness import touch
from hmrsim.world.model import World
from tests.profiles import examples

SIDE = 4.0
CELLS = {f"w{x}{y}": (SIDE * x, SIDE * y) for x in range(3) for y in range(2)}
PAIRS = [(a, b) for a, b in combinations(CELLS, 2) if dist(CELLS[a], CELLS[b]) == SIDE]
RADII = (0.2, 0.3, 0.45)
CLAW = {"claw": {"max_weight": 5.0}}


@st.composite
def worlds(draw):
    """Draw a small world with places on, near and beside lanes, and robots that don't touch at first."""
    lanes = draw(st.lists(st.sampled_from(PAIRS), min_size=3, unique=True))
    names = sorted({name for pair in lanes for name in pair})
    at = {name: CELLS[name] for name in names}
    spots = {}
    for number in range(draw(st.integers(0, 3))):
        (ax, ay), (bx, by) = (CELLS[name] for name in draw(st.sampled_from(lanes)))
        along, aside = draw(st.sampled_from([(0.0, 0.5), (0.5, 0.0), (0.5, 0.5), (0.4, 1.0), (0.6, 2.0)]))
        x, y = ax + along * (bx - ax), ay + along * (by - ay)
        spots[f"p{number}"] = (x + aside, y) if ax == bx else (x, y + aside)
    points = at | spots
    assume(len({*points.values()}) == len(points))
    robots = {
        f"robot_{number}": {"at": name, "base": {"radius": draw(st.sampled_from(RADII))}}
        for number, name in enumerate(draw(st.permutations([*points]))[: draw(st.integers(2, 4))])
    }
    for one, other in combinations(robots.values(), 2):
        assume(dist(points[one["at"]], points[other["at"]]) >= one["base"]["radius"] + other["base"]["radius"])
    doors = {}
    if draw(st.integers(0, 3)) == 0:
        (ax, ay), (bx, by) = (CELLS[name] for name in draw(st.sampled_from(lanes)))
        x, y = (ax + bx) / 2, (ay + by) / 2
        opens_for = draw(st.lists(st.sampled_from([*robots]), unique=True))
        doors["door"] = {"at": [[x - 1, y - 1], [x + 1, y + 1]], "opens_for": opens_for}
    return World.model_validate(
        {
            "waypoints": at,
            "lanes": [{"from": a, "to": b, "one_way": draw(st.integers(0, 3)) == 0} for a, b in lanes],
            "places": {name: {"at": at} for name, at in spots.items()},
            "docks": {"dock": {"at": robots["robot_0"]["at"]}} if draw(st.integers(0, 3)) == 0 else {},
            "doors": doors,
            "robots": robots,
        }
    )


class Exhaustive:
    """A search over the places of all robots by name."""

    def __init__(self, world, name, target):
        self.world = world
        self.names = [*world.robots]
        self.starts = [world.point(world.robots[robot].at) for robot in self.names]
        self.places = Places(world, [*self.starts, world.point(target)])
        self.name, self.target = name, self.places.number(world.point(target))
        self.radii = {robot: world.robot_type(world.robots[robot]).base.radius for robot in self.names}
        docks = {dock.at for dock in world.docks.values()}
        self.docked = {robot for robot in self.names if robot != name and world.robots[robot].at in docks}

    def reaches(self):
        """Return whether the robot gets to its target."""
        start = tuple(self.places.number(at) for at in self.starts)
        seen, todo = {start}, deque([start])
        while todo:
            state = todo.popleft()
            at = dict(zip(self.names, state, strict=True))
            if at[self.name] == self.target:
                return True
            for after in (*self.moves(at), *self.turns(at)):
                new = tuple((at | after).values())
                if new not in seen:
                    seen.add(new)
                    todo.append(new)
        return False

    def moves(self, at):
        """Yield the moves of one robot."""
        inside = Counter(at.values())
        for name, here in at.items():
            for move in self.places.moves[here]:
                end = self.places.all[move.end]
                is_open = end.waypoint or (name == self.name and move.end == self.target)
                if is_open and inside[move.end] < end.capacity and self.can_drive(name, move, at, [name]):
                    yield {name: move.end}

    def turns(self, at):
        """Yield the moves of all robots of a full ring."""
        for ring in self.places.rings:
            there = [[name for name in at if at[name] == move.start] for move in ring]
            if any(len(names) < self.places.all[move.start].capacity for names, move in zip(there, ring, strict=True)):
                continue
            for names in product(*there):
                if all(self.can_drive(name, move, at, names) for name, move in zip(names, ring, strict=True)):
                    yield {name: move.end for name, move in zip(names, ring, strict=True)}

    def can_drive(self, name, move, at, moving):
        """Return whether a robot can drive somewhere while others stand."""
        if name in self.docked or not (move.doors is None or name in move.doors):
            return False
        near = dict(move.near)
        return not any(
            at[other] in near and (near[at[other]] <= 0 or touch(near[at[other]], self.radii[name] + self.radii[other]))
            for other in at
            if other not in moving
        )


@examples(600)
@given(worlds(), st.data())
def test_a_robot_reaches_what_an_exhaustive_search_says(world, data):
    """The search agrees with an exhaustive one, and is never given up for so few robots."""
    name = data.draw(st.sampled_from([*world.robots]))
    place = data.draw(st.sampled_from([*world.waypoints, *world.places]))

    assert Exhaustive(world, name, place).reaches() is reaches(world, name, place)


def fleet(lanes, robots, *, docks=(), orders=(("w00", "w10"),), **more):
    """Return a world with robots that lift everything, at waypoints or places."""
    names = {name for lane in lanes for name in lane[:2]}
    return World.model_validate(
        {
            "waypoints": {name: at for name, at in CELLS.items() if name in names},
            "lanes": [*map(list, lanes)],
            "docks": {f"dock_{name}": {"at": name} for name in docks},
            "robots": {
                name: {"at": f"dock_{at}" if at in docks else at, "base": {"radius": 0.3}, "components": CLAW}
                for name, at in robots.items()
            },
            "demand": [
                {"name": f"order_{number}", "at": start, "to": end, "arrives": 1, "count": 1, "weight": 1.0}
                for number, (start, end) in enumerate(orders)
            ],
            **more,
        }
    )


ROW = [("w00", "w10"), ("w10", "w20")]
"""Three waypoints in a row."""

BAY = [*ROW, ("w10", "w11")]
"""With a place to step aside in the middle."""

RING = [("w00", "w10"), ("w10", "w11"), ("w11", "w01"), ("w01", "w00")]


@pytest.mark.parametrize(
    ("world", "answer"),
    [
        pytest.param(fleet(ROW, {"ann": "w20"}), "solvable", id="alone"),
        pytest.param(
            fleet(ROW, {"ann": "w20", "bob": "w00"}, orders=[("w00", "w20")]), "unsolvable", id="face to face"
        ),
        pytest.param(fleet(BAY, {"ann": "w20", "bob": "w00"}, orders=[("w00", "w20")]), "solvable", id="a bay"),
        pytest.param(fleet(BAY, {"ann": "w20", "bob": "w00"}, docks=["w00"]), "unsolvable", id="docked"),
        pytest.param(
            fleet(RING, dict(zip("abcd", ("w00", "w10", "w11", "w01"), strict=True))), "solvable", id="a full ring"
        ),
        pytest.param(
            fleet([*ROW, ("w01", "w11")], {"ann": "w20"}, orders=[("w00", "w11")]), "unsolvable", id="nowhere"
        ),
    ],
)
def test_worlds_made_by_hand(world, answer):
    """Each robot must be able to reach both places."""
    assert answer == solve(world, any_robot=False).answer


def test_any_robot_is_enough_if_that_is_asked_for():
    """Bob can't get past Ann, who can serve the order."""
    world = fleet(ROW, {"ann": "w10", "bob": "w20"}, orders=[("w00", "w10")])

    assert ("solvable", "unsolvable") == (solve(world).answer, solve(world, any_robot=False).answer)


def test_a_robot_too_wide_for_a_door_of_others_is_not_counted_on():
    """The door opens for no robot."""
    door = {"at": [[2, -1], [2, 1]], "opens_for": []}
    world = fleet(ROW, {"ann": "w20"}, doors={"door": door})

    assert "unsolvable" == solve(world).answer


def test_an_order_that_nobody_lifts_is_unsolvable():
    world = fleet(ROW, {"ann": "w20"})
    heavy = world.model_copy(update={"demand": [world.demand[0].model_copy(update={"weight": 50.0})]})

    verdict = solve(heavy)

    assert ("unsolvable", "no robot can serve order_0_1 from w00 to w10") == (verdict.answer, verdict.why)


def test_the_search_gives_up_after_so_many_configurations():
    world = fleet(BAY, {"ann": "w20", "bob": "w00"}, orders=[("w00", "w20")])

    assert "unknown" == solve(world, max_states=1).answer


def test_orders_are_those_of_a_simulation():
    world = fleet(BAY, {"ann": "w20"}, orders=[("w00", "w20"), ("w11", "w00")])
    simulator = Simulator(world)
    simulator.advance(10.0)

    placed = [(order.name, order.at, order.to) for order in simulator.demand.open.values()]
    assert [(order.name, order.start, order.end) for order in orders_of(world)] == placed


TWO_LANES = {
    "waypoints": {"a": [0, 0], "b": [10, 0], "c": [5, 0.5], "d": [5, 8]},
    "robot_types": {"cart": {"base": {"radius": 0.3}}},
    "robots": {"ann": {"type": "cart", "at": "a"}, "bob": {"type": "cart", "at": "c"}},
}
"""The second lane leads away from the first one, from where two robots touch."""


@pytest.mark.parametrize("order", [1, -1], ids=["the first lane", "the last lane"])
def test_a_robot_in_the_middle_of_a_lane_is_near_to_all_moves_on_a_lane_that_touches_it(order):
    """Both robots occupy their whole lanes, in either order."""
    lanes = [["a", "b"], ["c", "d"]][::order]
    places = Places(World.model_validate({**TWO_LANES, "lanes": lanes}), [(2.0, 0.0), (5.0, 6.0)])
    start, middle = places.number((2.0, 0.0)), places.number((5.0, 6.0))

    (away,) = [move for move in places.moves[start] if move.end == 0]
    assert 0.5 == dict(away.near)[middle]
