"""``hmrsim map info``."""

from __future__ import annotations

import json

import pytest

from hmrsim.cli import main

WORLD = """\
name: two islands
bounds: [0, 0, 20, 10]
waypoints: {a: [0, 0], b: [3, 4], c: [10, 0], d: [10, 2], alone: [15, 5]}
lanes: [[a, b], {from: c, to: d, one_way: true, capacity: 1}]
docks: {plug: {at: [1, 1]}}
items: {box: {at: b, weight: 2.5}}
robots: {eve: {at: a, type: fetcher, base: {speed: 1.5}, script: [Go b]}}
remap: {eve/grab: eve/pickup}
"""


@pytest.fixture
def path(tmp_path):
    """Return a small world."""
    file = tmp_path / "islands.yaml"
    file.write_text(WORLD)
    return file


@pytest.fixture
def info(path, capsys):
    """Return what is told of the small world, as JSON values."""
    code = main(["map", "info", str(path), "--json"])

    assert 0 == code
    return json.loads(capsys.readouterr().out)


def test_counts(info):
    """Everything is counted."""
    assert {
        "waypoints": 5,
        "lanes": 2,
        "walls": 0,
        "places": 0,
        "docks": 1,
        "doors": 0,
        "lifts": 0,
        "items": 1,
        "robot_types": 0,
        "robots": 1,
        "faults": 0,
    } == info["counts"]


def test_lanes_are_measured(info):
    """A lane counts once, whatever its direction."""
    assert (7.0, 1) == (info["lane_length"], info["one_way_lanes"])


def test_parts_that_no_lane_connects(info):
    """The largest first; a waypoint without a lane is a part of its own."""
    assert [2, 2, 1] == info["parts"]


def test_robots(info):
    """Where they stand, what they carry, how fast they are."""
    assert [
        {
            "name": "eve",
            "type": "fetcher",
            "components": ["claw"],
            "speed": 1.5,
            "at": [0.0, 0.0],
            "yaw": 0.0,
            "script": 1,
        }
    ] == info["robots"]


def test_items_are_where_their_waypoint_is(info):
    """A name of a point is told as the point."""
    assert [{"name": "box", "at": [3.0, 4.0], "weight": 2.5}] == info["items"]


def test_what_it_is(info, path):
    """The file, its format and its hash."""
    assert ("two islands", str(path), "native", "m") == tuple(info[key] for key in ("name", "file", "format", "units"))
    assert 64 == len(info["hash"])


def test_for_people(path, capsys):
    """The same in lines."""
    main(["map", "info", str(path)])

    lines = capsys.readouterr().out.splitlines()
    assert f"two islands ({path}, native)" == lines[0]
    assert "5 waypoints, 2 lanes, 1 dock, 1 item, 1 robot" in lines
    assert "lanes: 7 m in all, 1 one-way, in 3 parts of 2, 2, 1 waypoints" in lines
    assert "  eve (0, 0) fetcher, 1.5 m/s, claw, a script of 1 line" in lines
    assert "  eve/grab -> eve/pickup" in lines


def test_an_empty_world(tmp_path, capsys):
    """A world with nothing in it has no extent, and that is no error."""
    path = tmp_path / "empty.yaml"
    path.write_text("name: nothing\n")

    code = main(["map", "info", str(path), "--json"])
    assert (0, None) == (code, json.loads(capsys.readouterr().out)["extent"])


def test_what_the_command_line_adds_is_there(path, capsys):
    """The options of every command that takes a world."""
    main(["map", "info", str(path), "--robot", "bob@1,2", "--json"])

    assert ["eve", "bob"] == [robot["name"] for robot in json.loads(capsys.readouterr().out)["robots"]]


def test_a_file_that_is_not_there_is_2(capsys):
    """Who adds a suffix to the name of a shipped world is told its name."""
    code = main(["map", "info", "scenario1.yaml"])

    assert 2 == code
    assert "scenario1.yaml: no such file; the shipped world is called 'scenario1'\n" == capsys.readouterr().err
