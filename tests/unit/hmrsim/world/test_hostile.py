"""Files that are made to cost time and memory, and lines that go past many walls."""

from __future__ import annotations

import pytest

from hmrsim.errors import WorldError
from hmrsim.world import World
from hmrsim.world.segments import SegmentGrid
from hmrsim.world_checks import check_world, lanes, load_world


def test_number_of_reported_errors_is_limited(write):
    """The first one says how many there are."""
    path = write("\n".join(["name: many", *(f"k{i}: {i}" for i in range(3000))]))
    with pytest.raises(WorldError) as caught:
        load_world(path)

    first, second, *_ = caught.value.problems
    assert first.message == "has 3000 errors; only these are reported"
    assert (second.line, second.path) == (2, "k0")
    assert len(caught.value.problems) == 1000


def test_a_merge_key_is_told_with_its_line(errors_of):
    """It looks like YAML, and is so no longer."""
    errors = errors_of("robots:\n  eve: &eve {at: [0, 0]}\n  wall_e:\n    <<: *eve\n")

    assert errors == ["4: has the merge key <<, which YAML 1.2 no longer has; write the keys out"]


STRIPES = [((0.0, float(y)), (1000.0, float(y))) for y in range(1000)]


def test_a_short_line_is_compared_with_few_of_many_long_walls():
    """A thousand stripes, of which it meets one."""
    grid = SegmentGrid(STRIPES)

    assert grid.first_crossing((500.0, 700.5), (501.0, 701.5)) == 701
    assert grid.looked < 250


def test_a_line_from_far_away_is_cut_to_where_the_walls_are():
    """It crosses all of them in the end."""
    grid = SegmentGrid(STRIPES)

    assert grid.first_crossing((10.0, 1e7), (10.0, -1e7)) == 0
    assert grid.looked < 3000


def test_a_line_beside_all_walls_meets_none():
    """However long it is."""
    grid = SegmentGrid(STRIPES)

    assert grid.first_crossing((-1e7, -5000.0), (1e7, -5000.0)) is None


def test_lanes_and_walls_are_compared_within_bounds(monkeypatch):
    """What was not looked at is said."""
    monkeypatch.setattr(lanes, "_MAX_COMPARISONS", 0)
    world = World.model_validate(
        {
            "waypoints": {"a": [0, 0], "b": [2, 0], "c": [4, 0]},
            "lanes": [["a", "b"], ["b", "c"]],
            "walls": [[[1, -1], [1, 1]]],
        }
    )

    assert [(problem.path, problem.message) for problem in check_world(world)] == [
        ("lanes.0", "'a'-'b' crosses walls.0; a drawn lane is open all the same"),
        ("lanes", "and walls are too many to compare all; those from lanes.1 on were not"),
    ]
