"""Grid maps of the Moving AI benchmarks."""

from __future__ import annotations

import math
from itertools import product
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.errors import WorldError
from hmrsim.navigation.graph import WaypointGraph
from hmrsim.world import ReadOptions
from hmrsim.world.formats import movingai
from hmrsim.world_checks import load_world

ARENA = Path(__file__).parent / "data" / "arena.map"


def text(*rows, **header):
    """Return a map; *header* replaces lines of the header."""
    reported = {"type": "octile", "height": len(rows), "width": len(rows[0]), **header}
    return "\n".join([*(f"{key} {value}" for key, value in reported.items()), "map", *rows, ""])


def pairs(world):
    return {frozenset((lane.from_, lane.to)) for lane in world.lanes}


@pytest.fixture(scope="module")
def arena():
    return load_world(ARENA).world


def test_cells_are_waypoints(arena):
    assert (18, (0, 0, 6, 4)) == (len(arena.waypoints), arena.bounds)
    assert ((0.5, 3.5), (3.5, 2.5), (5.5, 0.5)) == tuple(arena.waypoints[cell] for cell in ("0_0", "3_1", "5_3"))


def test_neighbors_are_joined(arena):
    assert {frozenset(pair) for pair in (("2_0", "3_0"), ("2_0", "3_1"), ("3_2", "4_3"))} <= pairs(arena)
    assert frozenset(("3_1", "4_2")) not in pairs(arena)


def test_four_neighbors():
    world = load_world(ARENA, options=ReadOptions(neighbours=4)).world

    assert {1.0} == {math.dist(world.points[lane.from_], world.points[lane.to]) for lane in world.lanes}


def test_closed_cells_are_obstacles(arena):
    assert [((4, 2), (6, 4)), ((1, 1), (2, 3))] == [(wall.solid[0], wall.solid[2]) for wall in arena.walls]


def test_steps_have_the_benchmark_s_lengths(arena):
    route = WaypointGraph(arena).plan(arena.point("0_0"), arena.point("5_3"), 1.0)

    assert pytest.approx(4.0 + 2.0 * math.sqrt(2.0), abs=1e-9) == route.length


def test_water_is_reported():
    """The benchmarks allow swimming, but not from terrain."""
    assert ["map: cells of water: 1; nothing drives there"] == [
        f"{warning.path}: {warning.message}" for warning in load_world(ARENA).warnings
    ]


def test_lines_may_end_with_crlf(load):
    assert 2 == len(load(text("..", "@T").replace("\n", "\r\n"), "m.map").world.waypoints)


@pytest.mark.parametrize(
    ("content", "errors"),
    [
        (text("..", "...", ".?"), ["6: map: has a row of 3 cells, but a width of 2", "7: map: has '?' in column 1; "]),
        (text("..", height=3), ["5: height: has 1 rows, but a height of 3"]),
        (text("..", height=10**9), ["5: height: has 1 rows, but a height of 1000000000"]),
        (text("..", height="9" * 5000), ["1: height: expected a whole number above 0, got '999999"]),
        (text("..", width=0), ["1: width: expected a whole number above 0, got '0'"]),
        (text("..", width="\u0663"), ["1: width: expected a whole number above 0, got '\u0663'"]),
        (text("..", type="tile"), ["1: expected the lines `type octile`, `height …`, `width …` and `map`"]),
        ("?", ["1: expected the lines `type octile`, `height …`, `width …` and `map`"]),
    ],
)
def test_errors_are_reported_with_their_lines(errors_of, content, errors):
    found = errors_of(content, "m.map")

    assert len(errors) == len(found)
    assert all(line.startswith(error) for line, error in zip(found, errors, strict=True))


def test_an_oversized_grid_is_rejected(errors_of, monkeypatch):
    monkeypatch.setattr(movingai, "_MAX_OPEN", 3)

    assert ["4: map: has 4 cells to drive on; at most 3"] == errors_of(text("..", ".."), "m.map")


def test_the_neighbors_option_needs_a_grid(write):
    with pytest.raises(WorldError, match=r"--neighbours 4: there is no grid; only MovingAI maps are grids"):
        load_world(write("name: x\n"), options=ReadOptions(neighbours=4))


grids = st.integers(1, 6).flatmap(
    lambda width: st.lists(st.lists(st.booleans(), min_size=width, max_size=width), min_size=1, max_size=6)
)


@given(grids)
def test_obstacles_cover_each_closed_cell_once(rows):
    covered = [(x, y) for (x0, y0), (x1, y1) in movingai.blocks(rows) for x, y in product(range(x0, x1), range(y0, y1))]

    assert sorted((x, y) for y, row in enumerate(rows) for x, is_open in enumerate(row) if not is_open) == sorted(
        covered
    )


@given(grids, st.booleans())
def test_lanes_are_the_steps_of_the_benchmark(rows, diagonal):
    cells = {(x, y) for y, row in enumerate(rows) for x, is_open in enumerate(row) if is_open}
    around = [(dx, dy) for dx, dy in product((-1, 0, 1), repeat=2) if (dx, dy) != (0, 0) and (diagonal or not dx * dy)]
    expected = {
        frozenset(((x, y), (x + dx, y + dy)))
        for x, y in cells
        for dx, dy in around
        if {(x + dx, y + dy), (x + dx, y), (x, y + dy)} <= cells
    }
    numbers = movingai.numbered(rows)
    cell = {number: (x, y) for y, row in enumerate(numbers) for x, number in enumerate(row) if number >= 0}
    found = [frozenset((cell[a], cell[b])) for a, b in zip(*movingai.steps(numbers, diagonal=diagonal), strict=True)]

    assert (expected, len(expected)) == (set(found), len(found))
