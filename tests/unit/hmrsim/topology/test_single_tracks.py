"""Single tracks, on which robots can't pass each other."""

from __future__ import annotations

import math
from collections import defaultdict
from itertools import combinations, permutations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.topology.bottlenecks import SingleTracks
from hmrsim.world import World
from tests.profiles import examples


def tracks(lanes, rooms=None, **parts):
    names = sorted({name for lane in lanes for name in lane} | {stop for stops in parts.values() for stop in stops})
    points = {name: [number, number * number] for number, name in enumerate(names)}
    lifts = {name: {"stops": [*stops]} for name, stops in parts.items()}
    world = World.model_validate({"waypoints": points, "lanes": [[*lane] for lane in lanes], "lifts": lifts})
    return SingleTracks(world.graph, {name: (rooms or {}).get(name, 1) for name in names})


H = ["ax", "bx", "xm", "mn", "ny", "yc", "yd"]
"""Two junctions, x and y, with two waypoints each, and a corridor of m and n in between."""


def test_a_chain_between_two_junctions():
    """Junctions do not belong to it, since a robot can step aside there."""
    assert (("m", "n"),) == tracks(H).corridors


@pytest.mark.parametrize(
    ("lanes", "rooms"),
    [([*H, "bc"], {}), ([lane for lane in H if lane not in ("xm", "mn")] + ["xn"], {}), (H, {"m": 2}), (H, {"n": 3})],
    ids=["a way around", "a single waypoint", "room for two", "room for three"],
)
def test_lanes_with_a_way_around_are_no_single_track(lanes, rooms):
    assert () == tracks(lanes, rooms).corridors


def test_a_dead_end_is_a_single_track():
    assert (("p", "q", "r"),) == tracks(["ax", "bx", "xp", "pq", "qr"]).corridors


def test_one_way_lanes_are_no_single_track():
    one_way = [{"from": a, "to": b, "one_way": True} for a, b in ("mn", "xm", "ny")]
    lanes = [*([*lane] for lane in ("ax", "bx", "yc", "yd")), *one_way]
    points = {name: [number, number * number] for number, name in enumerate("abcdmnxy")}
    world = World.model_validate({"waypoints": points, "lanes": lanes})

    assert () == SingleTracks(world.graph, dict.fromkeys("abcdmnxy", 1)).corridors


def test_a_lift_ends_a_corridor():
    found = tracks(["ab", "bc", "de", "ef"], {"c": math.inf, "d": math.inf}, lift="cd")

    assert (("a", "b"), ("e", "f")) == found.corridors


def test_the_part_beyond_a_single_track_is_the_smaller_one():
    assert frozenset() == tracks([*H, "bc", "ad"]).cut_off("x")
    assert frozenset("ab") == tracks([*H, "nz"]).cut_off("x")
    assert frozenset("abx") == tracks([*H, "nz"]).cut_off("m")
    assert frozenset("abx") == tracks([*H, "nz"]).cut_off("x", "m")
    assert frozenset() == tracks([*H, "bc"]).cut_off("x", "m")


def test_a_cut_waypoint_has_room_for_one_robot_less():
    found = tracks(H, {"m": 2})
    (part,) = found.parts

    assert (9, 5) == (found.room(part), found.room_aside(part))


def can_swap(beside, one, other):
    """Return whether two robots can swap places by single moves to free waypoints."""
    todo, seen = [(one, other)], {(one, other)}
    for a, b in todo:
        moves = [(to, b) for to in beside[a] if to != b] + [(a, to) for to in beside[b] if to != a]
        todo += [move for move in moves if move not in seen and not seen.add(move)]
    return (other, one) in seen


@examples(200)
@given(st.lists(st.sampled_from([a + b for a, b in combinations("abcdef", 2)]), min_size=1, max_size=7, unique=True))
def test_two_robots_can_swap_unless_all_is_one_corridor(lanes):
    found = tracks(lanes)
    beside = defaultdict(set)
    for a, b in lanes:
        beside[a].add(b)
        beside[b].add(a)

    for part in found.parts:
        swapped = [can_swap(beside, one, other) for one, other in permutations(sorted(part), 2)]
        assert [frozenset(corridor) == part for corridor in found.corridors].count(True) == (not any(swapped))
        assert len({*swapped}) == 1
