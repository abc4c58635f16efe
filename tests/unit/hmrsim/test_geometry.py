"""Straight lines and obstacles on them."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.geometry import SAME_PLACE, Obstacles, PlaceNames, between, distance

NUMBERS = st.floats(-10, 10) | st.integers(-10, 10).map(float)
POINTS = st.tuples(NUMBERS, NUMBERS)


@pytest.mark.parametrize(
    ("walls", "x"),
    [
        ([], 4.0),
        ([[(2.0, -1.0), (2.0, 1.0)]], 2.0),
        ([[(3.0, -1.0), (3.0, 1.0)], [(2.0, 0.0), (2.0, 1.0)]], 2.0),
        ([[(2.0, -1.0), (4.0, 1.0)]], 3.0),
        ([[(3.0, 0.0), (1.0, 0.0)]], 1.0),
        ([[(-1.0, 0.0), (1.0, 0.0)]], 0.0),
    ],
)
def test_a_line_is_free_up_to_the_nearest_wall(walls, x):
    assert x == pytest.approx(4.0 * Obstacles(walls, []).free((0.0, 0.0), (4.0, 0.0)), abs=1e-5)


@given(
    POINTS,
    POINTS,
    st.lists(st.lists(POINTS, min_size=2, max_size=3), max_size=4),
    st.lists(st.lists(POINTS, min_size=3, max_size=4), max_size=1),
)
def test_the_free_part_of_a_line_is_clear(start, end, walls, solids):
    obstacles = Obstacles(walls, solids)
    share = obstacles.free(start, end)

    assert (share == 1.0) is not obstacles.block(start, end)
    assert not (share > 0.0 and obstacles.block(start, between(start, end, share)))


NEARBY = st.tuples(*[st.sampled_from([-1.0, 0.0, 1.0, 7.0]), st.integers(-3, 3)] * 2).map(
    lambda drawn: (drawn[0] + drawn[1] * SAME_PLACE / 2, drawn[2] + drawn[3] * SAME_PLACE / 2)
)


@given(points=st.lists(NEARBY, max_size=12), point=NEARBY)
def test_a_point_has_the_first_name_of_a_place_that_is_no_further_than_the_same_place(points, point):
    named = {f"p{number}": at for number, at in enumerate(points)}
    exact = next((name for name, at in named.items() if at == point), None)
    near = next((name for name, at in named.items() if distance(at, point) <= SAME_PLACE), None)

    assert PlaceNames(named).of(point) == (exact or near or f"({point[0]:g}, {point[1]:g})")
