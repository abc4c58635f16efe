"""Lanes of grids, which become objects only on demand."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.world.files import ReadOptions
from hmrsim.world.formats import movingai
from hmrsim.world.model import Lane, PlainLanes
from hmrsim.world_checks import checks, load_world, world_hash
from hmrsim.world_checks.loading import validate

ROOM = "type octile\nheight 3\nwidth 4\nmap\n...@\n.@..\n....\n"


def data_of(rows, neighbours=8):
    text = "\n".join(["type octile", f"height {len(rows)}", f"width {len(rows[0])}", "map", *rows])
    return movingai.FORMAT.read(text, "m.map", ReadOptions(neighbours=neighbours)).data


def judged(data):
    valid = validate(data)
    return [*valid.value.lanes], world_hash(valid.value), [*valid.findings, *checks.check(valid.value, valid.lost)]


rows = st.integers(1, 6).flatmap(
    lambda width: st.lists(st.text(".@", min_size=width, max_size=width), min_size=1, max_size=6)
)
points = st.tuples(st.integers(-2, 8), st.integers(-2, 8)).map(list)
walls = st.lists(st.lists(points, min_size=2, max_size=3).filter(lambda wall: wall[0] != wall[-1]), max_size=3)


@given(rows, st.sampled_from([4, 8]), walls, st.booleans())
def test_a_grid_equals_its_lanes_written_out(rows, neighbours, walls, lifted):
    data = data_of(rows, neighbours)
    data |= {"walls": [*data["walls"], *walls]}
    if lifted:
        data |= {"lifts": {"lift": {"stops": ["0_0", "3_0"]}}}
    written_out = data | {"lanes": [[*pair] for pair in data["lanes"]]}

    assert judged(written_out) == judged(data)


def test_lanes_of_a_grid_are_a_sequence():
    lanes = validate(data_of(["...", "@.."])).value.lanes

    assert isinstance(lanes, PlainLanes)
    assert lanes[0] == Lane(from_="0_0", to="1_0")
    assert lanes[-1] == Lane(from_="1_1", to="2_1")
    assert lanes[1:2] == (Lane(from_="1_0", to="2_0"),)
    assert tuple(lanes) == lanes
    assert lanes == validate(data_of(["...", "@.."])).value.lanes
    assert lanes != lanes[:2]
    with pytest.raises(IndexError):
        lanes[len(lanes)]


@pytest.mark.parametrize("grid_first", [True, False])
def test_a_file_may_add_lanes_to_a_grid(tmp_path, grid_first):
    """Lanes are in the order of the files."""
    (tmp_path / "room.map").write_text(ROOM)
    (tmp_path / "more.yaml").write_text("waypoints: {out: [9, 1]}\nlanes: [[3_1, out]]\n")
    files = ["room.map", "more.yaml"] if grid_first else ["more.yaml", "room.map"]
    (tmp_path / "all.yaml").write_text(f"include: {files}\nrobots: {{r: {{at: 0_0}}}}\n")
    alone, both = load_world(tmp_path / "room.map").world, load_world(tmp_path / "all.yaml")
    added = [("3_1", "out")]
    own = [(lane.from_, lane.to) for lane in alone.lanes]

    assert [(lane.from_, lane.to) for lane in both.world.lanes] == (own + added if grid_first else added + own)


def test_a_problem_names_its_file(tmp_path):
    (tmp_path / "room.map").write_text(ROOM)
    (tmp_path / "all.yaml").write_text("include: [room.map]\nwalls: [[[0, 0], [1, 3]]]\nplaces: {p: {at: [50, 1]}}\n")
    warnings = [str(problem).replace(str(tmp_path), "") for problem in load_world(tmp_path / "all.yaml").warnings]

    assert [
        "/all.yaml:3: places.p.at: (50, 1) is outside the map, which spans (0, 0) to (4, 3)",
        "/room.map:4: lanes.1: '0_0'-'0_1' crosses walls.0; a drawn lane is open all the same",
    ] == [warning for warning in warnings if "lanes.1:" in warning or "places" in warning]
