"""The policy for dense fleets."""

from __future__ import annotations

import math
import random
from itertools import pairwise

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from hmrsim.navigation.adjacency import Adjacency
from hmrsim.protocol.commands import SendGoal
from hmrsim.traffic.policies._streets import against
from hmrsim.world.model import World
from hmrsim.world_checks import load_world
from tests.profiles import examples
from tests.simulation import simulate
from tests.unit.hmrsim.traffic.test_traffic import EVENTS, TRACK, check_places, end, go, grid

A, B, C = (letter * 32 for letter in "abc")
PLANNED = {"policy": "planned", "patience": None}


def planned(world, **settings):
    """Return a simulation of a world under the policy."""
    return simulate({**world, "traffic": {**PLANNED, **settings}}, topics=EVENTS)


def works(robot, seconds, goal_id):
    """Return the command that makes a robot stand still for some seconds."""
    from hmrsim.interfaces.nav2_msgs import Wait  # noqa: PLC0415 - for some tests

    return SendGoal(robot, "wait", Wait.Goal.model_validate({"time": {"sec": seconds}}), goal_id)


class TestTurningOff:
    """A robot whose lane is taken takes an equally good one."""

    def test_a_robot_does_not_turn_off_towards_a_door_closed_to_it(self):
        """The shortcut would make it drive there and back forever."""
        world = load_world("zoo/door").world.model_dump(exclude_unset=True)
        world["robots"] = {"burn_e": {"type": "porter", "at": "east_exit"}, "m_o": {"type": "porter", "at": "east_bed"}}
        run = planned(world)
        log = run((0.0, works("burn_e", 100, A)), (1.0, go("m_o", 3, 3, B)), until=300.0)

        assert [] == log.happened("rerouted")
        assert "SUCCEEDED" == end(log, B)[1]

    def test_a_robot_takes_another_lane_that_leads_nearer_to_its_goal(self):
        ends = []
        for taken in ("n01", "n10"):
            run = planned(grid(3, 3, ann=("n00", 1.0), bob=(taken, 1.0)), one_way=0)
            log = run((0.0, works("bob", 30, B)), (1.0, go("ann", 20, 20, A)), until=100.0)
            ends.append(end(log, A))

        assert [(41.0, "SUCCEEDED", "")] * 2 == ends

    def test_a_robot_waits_where_other_lanes_lead_away(self):
        world = grid(3, 2, ann=("n00", 1.0), bob=("n10", 1.0))
        run = planned(world, grace=0.0)
        log = run((0.0, works("bob", 7, B)), (1.0, go("ann", 10, 0, A)), until=100.0)

        assert (17.0, "SUCCEEDED", "") == end(log, A)

    def test_a_much_longer_detour_is_not_taken(self):
        world = {
            "waypoints": {"a": [0, 0], "b": [10, 0], "c": [20, 0], "d": [10, 40]},
            "lanes": [["a", "b"], ["b", "c"], ["a", "d"], ["d", "c"]],
            "robots": {"ann": {"at": "a"}, "bob": {"at": "b"}},
        }
        log = planned(world)((0.0, works("bob", 5, B)), (1.0, go("ann", 20, 0, A)), until=200.0)

        assert [] == log.happened("rerouted")


class TestMakingRoom:
    def test_two_robots_pass_each_other_at_a_bay(self):
        log = planned(TRACK)((0.0, go("ann", 20, 0, A)), (0.0, go("bob", 0, 0, B)))

        assert ["SUCCEEDED"] * 2 == [end(log, goal)[1] for goal in (A, B)]

    def test_a_robot_makes_room_nearest_to_its_goal(self):
        world = grid(3, 3, ann=("n01", 1.0), bob=("n11", 1.0), eve=("n12", 1.0), dan=("n21", 1.0))
        run = planned(world, one_way=0)
        log = run((0.0, works("dan", 60, C)), (1.0, go("ann", 10, 10, A)), (2.0, go("bob", 20, 20, B)), until=100.0)

        assert {"SUCCEEDED"} == {end(log, goal)[1] for goal in (A, B)}

    def test_a_robot_that_can_not_make_room_aborts_with_the_circle(self):
        world = {**TRACK, "lanes": TRACK["lanes"][:2]}
        log = planned(world)((0.0, go("ann", 20, 0, A)), (0.0, go("bob", 0, 0, B)))

        text = (
            "deadlock: ann waits for bob waits for ann; there is no other way;"
            " what would help: send one of them elsewhere, or add room where two can pass"
        )
        assert (10.0, "ABORTED", text) == end(log, B)

    def test_a_robot_stopped_on_a_lane_leaves_it_by_the_free_end(self):
        run = planned(TRACK)
        run((0.0, go("bob", 15, 0, A)))
        log = run((10.0, go("ann", 20, 0, B)))

        assert ("SUCCEEDED", (20.0, 0.0)) == (end(log, B)[1], run.simulator.robots["ann"].pose().point)

    def test_a_stream_of_crossing_robots_does_not_block_an_earlier_one_forever(self):
        world = grid(4, 3, ann=("n01", 0.5), **{f"r{i}": (f"n{i}0", 2.0) for i in range(4)})
        run = planned(world)
        chance = random.Random(1)
        commands = [(0.0, go("ann", 30, 10, A))]
        for number in range(200):
            robot = f"r{number % 4}"
            x, y = chance.choice([0, 10, 20, 30]), chance.choice([0, 20])
            commands.append((number * 2.5, go(robot, x, y, f"{number + 1:032x}")))
        log = run(*commands, until=500.0)

        assert "SUCCEEDED" == end(log, A)[1]
        assert end(log, A)[0] < 200.0


@st.composite
def full_grids(draw):
    """Return a grid with all or nearly all waypoints taken, and the destination of each robot."""
    columns, rows = draw(st.sampled_from([(2, 2), (3, 2), (3, 3), (4, 3), (5, 4)]))
    names = sorted(grid(columns, rows)["waypoints"])
    number = len(names) - draw(st.integers(0, 2))
    starts = draw(st.permutations(names))[:number]
    world = grid(
        columns, rows, **{f"r{i}": (at, draw(st.sampled_from([0.5, 1.0, 2.0]))) for i, at in enumerate(starts)}
    )
    if draw(st.booleans()):
        for robot in world["robots"].values():
            robot["base"]["turning_rate"] = draw(st.sampled_from([0.5, 2.0]))
    times = st.sampled_from([0.0, 0.0, 5.0, 7.5])
    return world, sorted((draw(times), name, draw(st.sampled_from(names))) for name in world["robots"])


def all_to_one_corner():
    """Return a full grid of slow robots that all turn at one corner, where each has to make room at once."""
    names = sorted(grid(4, 3)["waypoints"])
    world = grid(4, 3, **{f"r{i}": (name, 0.5) for i, name in enumerate(names)})
    for robot in world["robots"].values():
        robot["base"]["turning_rate"] = 0.5
    elsewhere = {"r1": "n02", "r9": "n30"}
    return world, sorted((0.0, name, elsewhere.get(name, "n00")) for name in world["robots"])


@examples(25)
@given(crowd=full_grids())
@example(crowd=all_to_one_corner())
def test_every_goal_is_reached_on_a_full_grid(crowd):
    """Every lane is part of a ring, so all robots can move, and no two are ever in one place."""
    world, goals = crowd
    run = planned(world)
    simulator, points = run.simulator, world["waypoints"]
    for number, (at, robot, goal) in enumerate(goals, 1):
        simulator.advance(at)
        simulator.submit(go(robot, *points[goal], f"{number:032x}"))
    while simulator.process_events(math.inf, 7, idle=False):
        check_places(simulator)
        assert simulator.now < 10_000.0

    assert {"SUCCEEDED"} == {run.log.changes(f"{number:032x}")[-1][1] for number in range(1, len(goals) + 1)}


class TestStreets:
    @staticmethod
    def directions(world):
        """Return the lanes against their street's direction, by the names of their ends."""
        ways = Adjacency(World.model_validate(world))
        return {(ways.names[ways.starts[n]], ways.names[ways.ends[n]]) for n in against(ways)}

    def test_parallel_streets_alternate_along_both_axes(self):
        against_it = self.directions(grid(4, 4))

        rows = [[(f"n{x}{y}", f"n{x + 1}{y}") in against_it for x in range(3)] for y in range(4)]
        columns = [[(f"n{x}{y}", f"n{x}{y + 1}") in against_it for y in range(3)] for x in range(4)]
        assert all(len({*street}) == 1 for street in rows + columns)
        assert all(a[0] != b[0] for lines in (rows, columns) for a, b in pairwise(lines))

    def test_each_lane_has_one_preferred_direction(self):
        against_it = self.directions(grid(4, 4))

        assert len(against_it) == 24
        assert not any((b, a) in against_it for a, b in against_it)

    @pytest.mark.parametrize(
        "fields",
        [
            {"lanes": [["n00", "n10"], ["n10", "n20"]]},
            {"lanes": [{"from": a, "to": b, "one_way": True} for a, b in pairwise(["n00", "n10", "n20", "n30"])]},
            {"lanes": [["n00", "n11"], ["n11", "n20"], ["n20", "n31"], ["n31", "n22"]]},
        ],
        ids=["short", "one way", "zigzag"],
    )
    def test_lanes_outside_streets_have_no_preferred_direction(self, fields):
        assert set() == self.directions({**grid(4, 4), **fields})

    def test_a_route_follows_the_directions_of_streets(self):
        """A setting turns that off."""
        corners = [(0.0, 0.0), (30.0, 0.0), (0.0, 30.0), (30.0, 30.0)]
        taken = {}
        for one_way in (0, 1):
            plan = planned(grid(4, 4, ann=("n00", 1.0)), one_way=one_way).simulator.robots["ann"].plan_to
            routes = [plan((30.0 - x, 30.0 - y), (x, y)) for x, y in corners]
            taken[one_way] = [leg.lane for route in routes for leg in route.legs]

        assert {4 * 6} == {len(legs) for legs in taken.values()}
        wrong = self.directions(grid(4, 4))
        assert sum(lane in wrong for lane in taken[1]) < sum(lane in wrong for lane in taken[0])
