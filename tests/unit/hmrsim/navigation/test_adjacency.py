"""The arrays of lanes, compared with the lanes of the world."""

from __future__ import annotations

import math

from hypothesis import given
from hypothesis import strategies as st

from hmrsim.navigation.adjacency import Adjacency, Numbers
from hmrsim.navigation.lanes import Lanes
from hmrsim.world.model import World

NAMES = ["a", "b", "c", "d", "e", "f"]

lanes = st.lists(
    st.tuples(
        st.sampled_from([(a, b) for a in NAMES for b in NAMES if a < b]),
        st.booleans(),
        st.booleans(),
        st.sampled_from([None, 0.5, 2.0]),
    ),
    unique_by=lambda lane: lane[0],
)
lifts = st.lists(st.lists(st.sampled_from(NAMES), min_size=2, max_size=3, unique=True), max_size=1)


@st.composite
def worlds(draw):
    drawn = draw(lanes)
    return World.model_validate(
        {
            "waypoints": {name: [3.0 * i, 4.0 * (i % 2)] for i, name in enumerate(reversed(NAMES))},
            "lanes": [
                {"from": ends[back], "to": ends[not back], "one_way": one_way}
                | ({"speed_limit": limit} if limit else {})
                for ends, back, one_way, limit in drawn
            ],
            "lifts": {f"lift{i}": {"stops": stops} for i, stops in enumerate(draw(lifts))},
        }
    )


def sorted_ways(world):
    return sorted(world.ways, key=lambda way: (way.start, way.end))


@given(worlds())
def test_lanes_are_numbered_by_name(world):
    made = Lanes(world)
    edges = [made.edges[number] for number in range(len(world.ways))]
    legs = [edge.leg for edge in edges]

    assert [((way.start, way.end), way.length, way.speed_limit, way.ride) for way in sorted_ways(world)] == [
        (leg.lane, leg.length, leg.speed_limit, leg.ride) for leg in legs
    ]
    assert [(edge.number, made.names[edge.start], made.names[edge.end]) for edge in edges] == [
        (number, way.start, way.end) for number, way in enumerate(sorted_ways(world))
    ]


@given(worlds())
def test_both_directions_share_a_slot(world):
    made = Lanes(world)
    tracks: dict[frozenset[str], int] = {}
    for way in sorted_ways(world):
        tracks.setdefault(frozenset((way.start, way.end)), len(made.names) + len(tracks))

    assert [made.legs[number].slots[0] for number in range(len(world.ways))] == [
        tracks[frozenset((way.start, way.end))] for way in sorted_ways(world)
    ]
    assert [frozenset(ends) for ends in made.tracks] == [*tracks]
    assert {slot: [edge.leg.lane for edge in made.leading_to(slot)] for slot in tracks.values()} == {
        slot: [(way.start, way.end) for way in sorted_ways(world) if {way.start, way.end} == ends]
        for ends, slot in tracks.items()
    }


@given(worlds())
def test_lanes_are_found_by_their_ends(world):
    made, expected = Lanes(world), [(way.start, way.end) for way in sorted_ways(world)]

    assert expected == [*made.numbers]
    assert [*range(len(expected))] == [made.numbers[ends] for ends in expected]
    assert [pair in expected for pair in ((a, b) for a in NAMES for b in NAMES)] == [
        pair in made.numbers for pair in ((a, b) for a in NAMES for b in NAMES)
    ]
    for node, name in enumerate(made.names):
        assert [ends for ends in expected if ends[0] == name] == [edge.leg.lane for edge in made.out[node]]
        assert [ends for ends in expected if ends[1] == name] == [edge.leg.lane for edge in made.into[node]]


@given(worlds(), st.sampled_from([0.25, 1.0, 3.0]))
def test_durations_of_all_lanes_equal_those_of_each(world, speed):
    """Durations are equal to the last bit, because ties between routes depend on it."""
    ways = Adjacency(world)

    assert [way.seconds(speed) for way in sorted_ways(world)] == ways.seconds(speed).tolist()


def test_unknown_names_are_no_lanes():
    numbers = Numbers(Adjacency(World.model_validate({"waypoints": {"a": [0, 0]}})))

    assert (None, 0) == (numbers.get(("a", "b")), len(numbers))


def test_the_last_of_two_lanes_between_the_same_waypoints_counts():
    world = World.model_validate(
        {
            "waypoints": {"a": [0, 0], "b": [3, 4]},
            "lanes": [{"from": "a", "to": "b", "speed_limit": 1.0}],
            "lifts": {"lift": {"stops": ["a", "b"], "travel_time": 7.0, "door_time": 1.0}},
        }
    )

    assert [(0.0, 9.0, math.inf)] * 2 == [
        (leg.length, leg.ride, leg.speed_limit) for leg in map(Lanes(world).legs.__getitem__, range(2))
    ]
