"""Lanes that cross without a waypoint, and lanes nearer to each other than robots are wide."""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import combinations, product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.geometry import gap
from hmrsim.protocol.commands import CancelGoal
from hmrsim.protocol.topics import Topic
from hmrsim.traffic.nearness import near_slots
from tests.profiles import examples
from tests.simulation import simulate
from tests.unit.hmrsim.traffic.runs import end, go, under

A, B = "a" * 32, "b" * 32


def squared(p, a, b):
    """Return the exact square of the distance of a point from a segment."""
    (px, py), (ax, ay), (bx, by) = p, a, b
    dx, dy = bx - ax, by - ay
    length = dx * dx + dy * dy
    share = min(max(Fraction((px - ax) * dx + (py - ay) * dy, length), Fraction(0)), Fraction(1)) if length else 0
    return (ax + share * dx - px) ** 2 + (ay + share * dy - py) ** 2


def cut(a, b, c, d):
    """Return whether two segments cross, with the ends of each on either side of the other."""

    def side(p, q, r):
        return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])

    return side(a, b, c) * side(a, b, d) < 0 and side(c, d, a) * side(c, d, b) < 0


def exact_gap(a, b, c, d):
    """Return the exact square of the distance of two segments."""
    return 0 if cut(a, b, c, d) else min(squared(a, c, d), squared(b, c, d), squared(c, a, b), squared(d, a, b))


COORDINATES = st.tuples(st.integers(-6, 6), st.integers(-6, 6))


@examples(400)
@given(*[COORDINATES] * 4)
def test_the_gap_of_two_segments_is_exact(a, b, c, d):
    assert math.isclose(gap(a, b, c, d), math.sqrt(exact_gap(a, b, c, d)), abs_tol=1e-12)


@st.composite
def networks(draw):
    """Return waypoints, and pairs of them with lanes in between."""
    points = draw(st.lists(COORDINATES, min_size=2, max_size=14, unique=True))
    pairs = [*combinations(range(len(points)), 2)]
    return points, draw(st.lists(st.sampled_from(pairs), max_size=14, unique=True))


@examples(400)
@given(networks(), st.sampled_from([0.0, 0.75, 1.0, 2.5, 9.0]))
def test_the_grid_finds_the_same_neighbors_as_comparing_all_pairs(network, reach):
    points, lanes = network
    ends = dict(enumerate([*((i, i) for i in range(len(points))), *lanes]))
    near = near_slots([(float(x), float(y)) for x, y in points], ends, reach)

    expected = set()
    for (one, (a, b)), (other, (c, d)) in combinations(ends.items(), 2):
        away = exact_gap(points[a], points[b], points[c], points[d])
        if {a, b}.isdisjoint((c, d)) and (away == 0 or away < (reach - 1e-6) * abs(reach - 1e-6)):
            expected |= {(one, other), (other, one)}
    assert expected == {(one, other) for one, others in near.items() for other in others}


def test_lanes_of_a_lattice_are_no_neighbors():
    """Robots as wide as a cell just fit beside each other, whatever the rounding."""
    columns = range(8)
    points = [(x * 0.1, y * 0.1) for x in columns for y in columns]
    tracks = [(8 * x + y, 8 * x + y + 1) for x in columns for y in range(7)]
    tracks += [(8 * x + y, 8 * x + y + 8) for x in range(7) for y in columns]
    ends = dict(enumerate([*((i, i) for i in range(64)), *tracks]))

    assert {} == near_slots(points, ends, 0.1)


CROSS = {
    "waypoints": {"west": [0, 0], "east": [20, 0], "north": [10, 10], "south": [10, -10]},
    "lanes": [["west", "east"], ["north", "south"]],
    "robots": {"ann": {"at": "west"}, "bob": {"at": "north"}},
}
BESIDE = {
    "waypoints": {"a": [0, 0], "b": [20, 0], "c": [10, 10], "d": [10, 0.6]},
    "lanes": [["a", "b"], ["c", "d"]],
    "robot_types": {"slim": {"base": {"radius": 0.2}}, "wide": {"base": {"radius": 0.4}}},
}


@pytest.mark.parametrize("policy", ["reserve", "priority"])
def test_the_later_robot_waits_where_lanes_cross_without_a_waypoint(policy):
    log = under(policy, CROSS)((0.0, go("ann", 20, 0, A)), (0.0, go("bob", 10, -10, B)))

    waiting = {"robot": "bob", "at": [10.0, 10.0], "lane": ["north", "south"], "for": ["ann"]}
    assert [(0.0, waiting)] == log.happened("waiting")
    assert [(20.0, {"robot": "bob", "waited": 20.0})] == log.happened("went_on")
    assert [(20.0, "SUCCEEDED", ""), (40.0, "SUCCEEDED", "")] == [end(log, A), end(log, B)]


def test_lanes_with_room_for_any_number_do_not_exclude_each_other():
    log = under("reserve", CROSS, lane_capacity=None)((0.0, go("ann", 20, 0, A)), (0.0, go("bob", 10, -10, B)))

    assert [(20.0, "SUCCEEDED", "")] * 2 == [end(log, A), end(log, B)]


@pytest.mark.parametrize(("kind", "ends"), [("slim", 9.4), ("wide", 29.4)])
def test_a_waypoint_is_too_near_to_a_lane_for_robots_that_are_wide(kind, ends):
    """Only the two robots matter, not others."""
    robots = {"ann": {"at": "a", "type": kind}, "bob": {"at": "c", "type": kind}}
    world = {**BESIDE, "robots": robots}
    log = under("reserve", world)((0.0, go("ann", 20, 0, A)), (0.0, go("bob", 10, 0.6, B)))

    assert [(20.0, "SUCCEEDED", ""), (ends, "SUCCEEDED", "")] == [end(log, A), end(log, B)]


ROBOTS_BESIDE = {"ann": {"at": "a", "type": "wide"}, "bob": {"at": "d", "type": "wide"}}


def test_a_robot_that_stands_beside_the_lane_blocks_it_under_reserve():
    log = under("reserve", {**BESIDE, "robots": ROBOTS_BESIDE}, patience=5.0)((0.0, go("ann", 20, 0, A)))

    at, status, text = end(log, A)
    assert (5.0, "ABORTED") == (at, status)
    assert text.startswith("blocked for 5 s: ann has waited at a since 0 s for bob, which makes no room")


def test_a_robot_that_stands_beside_the_lane_yields_under_priority():
    run = under("priority", {**BESIDE, "robots": ROBOTS_BESIDE})
    log = run((0.0, go("ann", 20, 0, A)))

    made_room = {"robot": "bob", "by": "ann", "from": [10.0, 0.6], "to": [10.0, 10.0]}
    assert [(0.0, made_room)] == log.happened("made_room")
    assert (29.4, "SUCCEEDED", "") == end(log, A)


def test_robots_that_were_put_too_near_each_other_can_leave():
    waypoints = {"a": [0, 0], "b": [10, 0], "c": [0, 0.6], "d": [10, 10]}
    robots = {name: {"at": at, "base": {"radius": 0.4}} for name, at in (("ann", "a"), ("bob", "c"))}
    world = {"waypoints": waypoints, "lanes": [["a", "b"], ["c", "d"]], "robots": robots}
    log = under("reserve", world)((0.0, go("ann", 10, 0, A)))

    assert (10.0, "SUCCEEDED", "") == end(log, A)


def test_a_robot_does_not_yield_to_a_place_that_is_too_near():
    waypoints = {**BESIDE["waypoints"], "e": [13, 0.6]}
    world = {**BESIDE, "waypoints": waypoints, "lanes": [*BESIDE["lanes"], ["d", "e"]], "robots": ROBOTS_BESIDE}
    log = under("priority", world)((0.0, go("ann", 20, 0, A)))

    assert [[10.0, 10.0]] == [told["to"] for _, told in log.happened("made_room")]
    assert (29.4, "SUCCEEDED", "") == end(log, A)


def test_no_robot_is_placed_where_it_would_touch_a_distant_one_that_comes():
    run = under("reserve", {**BESIDE, "robots": ROBOTS_BESIDE})
    run.ask("set_entity_state", {"entity": "bob", "state": {"pose": {"position": {"x": 10.0, "y": 10.0}}}})
    run.ask("set_entity_state", {"entity": "ann", "state": {"pose": {"position": {"x": 2.0}}}})
    back = {"pose": {"position": {"x": 10.0, "y": 0.6}}}
    answer = run.ask("set_entity_state", {"entity": "bob", "state": back})

    text = "(10, 0.6) is near lane a-b, which ann has, where there is no room for one more robot"
    assert text == answer.result.error_message


@st.composite
def tangles(draw):
    """Return a world of waypoints in a grid with crossing lanes, its robots, and their destinations."""
    points = {f"n{x}{y}": [10 * x, 10 * y] for x in range(3) for y in range(3)}
    pairs = [list(pair) for pair in combinations(points, 2)]
    lanes = draw(st.lists(st.sampled_from(pairs), min_size=4, max_size=12, unique_by=tuple))
    touched = sorted({name for lane in lanes for name in lane})
    starts = draw(st.permutations(touched))[: draw(st.integers(2, 5))]
    radii = st.sampled_from([None, 0.5, 2.0, 3.0])
    robots = {f"r{i}": {"at": at, "base": {"radius": draw(radii)}} for i, at in enumerate(starts)}
    goals = {name: draw(st.sampled_from(touched)) for name in robots}
    return {"waypoints": points, "lanes": lanes, "robots": robots}, goals


def check_apart(simulator):
    """Fail if two robots hold slots in which their footprints touch.

    Lanes that share a waypoint don't count, so that one may come by on the one where another has stopped on the other.
    """
    slots = simulator.roster.admission._rules.slots
    for one, other in combinations(simulator.robots.values(), 2):
        for here, there in product(slots.held(one), slots.held(other)):
            if slots.touch(one, [here], other, there):
                assert comes_by(simulator, one, here, other, there), (simulator.now, one.name, other.name)


def comes_by(simulator, one, here, other, there):
    """Return whether one robot has stopped in the middle of a lane, and the other is on or from an adjacent one."""
    slots, lanes = simulator.roster.admission._rules.slots, simulator.graph.lanes
    if here not in slots.points:
        one, here, other, there = other, there, one, here
    own = [slot for slot in slots.held(one) if slots.is_lane(slot)]
    if here not in slots.points or not own or there in slots.points:
        return False
    ends = {*lanes.tracks[own[0] - len(lanes.names)]}
    return not ends.isdisjoint(lanes.tracks[there - len(lanes.names)] if slots.is_lane(there) else [lanes.names[there]])


@pytest.mark.parametrize("policy", ["reserve", "priority"])
@examples(60, share_fixtures=True)
@given(tangles(), st.lists(st.integers(0, 40), max_size=4))
def test_robots_never_touch(policy, tangle, cancels):
    """Goals are canceled after some events, and under reserve every goal ends."""
    world, goals = tangle
    run = simulate({**world, "traffic": {"policy": policy}}, topics=frozenset({Topic.EVENTS}))
    simulator = run.simulator
    sent = [go(name, *world["waypoints"][goal], f"{i:032x}") for i, (name, goal) in enumerate(goals.items(), 1)]
    for command in sent:
        simulator.submit(command)
    for number in range(5_000):
        if not simulator.process_events(math.inf, 1, idle=False):
            break
        check_apart(simulator)
        for command in sent if number in cancels else ():
            simulator.submit(CancelGoal(command.robot, command.action, command.goal_id))

    if policy == "reserve":
        ends = {run.log.changes(command.goal_id)[-1][1] for command in sent}
        assert {"SUCCEEDED", "ABORTED", "CANCELED"}.issuperset(ends)
