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
    """Return the output for the small world, as JSON values."""
    code = main(["map", "info", str(path), "--json"])

    assert 0 == code
    return json.loads(capsys.readouterr().out)


def test_counts(info):
    """All entities are counted."""
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
    """The largest part comes first; a waypoint without lanes is a separate part."""
    assert [2, 2, 1] == info["parts"]


def test_robots(info):
    """The position, the components and the speed of each robot are shown."""
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
    """Names of points are replaced by the points."""
    assert [{"name": "box", "at": [3.0, 4.0], "weight": 2.5}] == info["items"]


def test_what_it_is(info, path):
    """The file, its format and its hash."""
    assert ("two islands", str(path), "native", "m") == tuple(info[key] for key in ("name", "file", "format", "units"))
    assert 64 == len(info["hash"])


def test_text(path, capsys):
    """Text has the same content."""
    main(["map", "info", str(path)])

    lines = capsys.readouterr().out.splitlines()
    assert f"two islands ({path}, native)" == lines[0]
    assert "5 waypoints, 2 lanes, 1 dock, 1 item, 1 robot" in lines
    assert "lanes: 7 m in all, 1 one-way, in 3 parts of 2, 2, 1 waypoints" in lines
    assert "  eve (0, 0) fetcher, 1.5 m/s, claw, a script of 1 line" in lines
    assert "  eve/grab -> eve/pickup" in lines


def test_an_empty_world(tmp_path, capsys):
    """An empty world has no extent, which is not an error."""
    path = tmp_path / "empty.yaml"
    path.write_text("name: nothing\n")

    code = main(["map", "info", str(path), "--json"])
    assert (0, None) == (code, json.loads(capsys.readouterr().out)["extent"])


def test_what_the_command_line_adds_is_there(path, capsys):
    """``--robot`` and ``--item`` add entities."""
    main(["map", "info", str(path), "--robot", "bob@1,2", "--json"])

    assert ["eve", "bob"] == [robot["name"] for robot in json.loads(capsys.readouterr().out)["robots"]]


def test_a_file_that_is_not_there_is_2(capsys):
    """The error for a shipped world's name with a suffix gives the name."""
    code = main(["map", "info", "scenario1.yaml"])

    assert 2 == code
    assert "scenario1.yaml: no such file; the shipped world is called 'scenario1'\n" == capsys.readouterr().err


BRIDGE = """\
name: bridge
waypoints: {a: [0, 0], b: [4, 0], c: [4, 3], d: [20, 0], e: [24, 0], f: [24, 3]}
lanes: [[a, b], [b, c], [c, a], [d, e], [e, f], [f, d], {from: b, to: d, one_way: true}]
doors: {gate: {at: [[12, -1], [12, 1]]}}
places: {desk: {at: [0, 0]}, shelf: {at: [24, 3]}}
docks: {plug: {at: c}}
"""


def test_the_network_as_text(tmp_path, capsys):
    """Bottlenecks, what can't be reached, trips and traffic, in aligned columns."""
    path = tmp_path / "bridge.yaml"
    path.write_text(BRIDGE)
    main(["map", "info", str(path)])

    lines = capsys.readouterr().out.splitlines()
    start = lines.index("bottlenecks: 2 waypoints, 1 lane; each is the only way between its sides, the worst first")
    assert [
        "  lane      b - d (door gate)  cuts off 3 of 6 waypoints  1 place: shelf",
        "  waypoint  b                  cuts off 2 of 6 waypoints  2 places: desk, plug",
        "  waypoint  d                  cuts off 2 of 6 waypoints  1 place: shelf",
        "unreachable: 2 pairs of places and docks",
        "  shelf  to desk, plug  no lane leads there",
        "trips between 3 places and docks, without turning and acceleration:",
    ] == lines[start + 1 : start + 7]
    assert "  longest by time  desk -> shelf  25.0 m     25.0 s" in lines
    assert "traffic: share of the quickest trips between 3 waypoints with places or docks at 1 m/s" in lines
    assert "  b - d  50.0%" in lines


def test_the_network_as_json(tmp_path, capsys):
    """JSON also has everything that the text omits."""
    path = tmp_path / "bridge.yaml"
    path.write_text(BRIDGE)
    main(["map", "info", str(path), "--json"])

    network = json.loads(capsys.readouterr().out)["network"]
    sides = [{"waypoints": 3, "places": ["desk", "plug"]}, {"waypoints": 3, "places": ["shelf"]}]
    assert {"kind": "lane", "name": ["b", "d"], "sides": sides, "doors": ["gate"]} in network["bottlenecks"]["worst"]
    assert {"from": "shelf", "to": "desk", "why": "no lane leads there"} == network["unreachable"]["listed"][0]
    (longest, *_) = network["trips"]["longest_by_length"]
    assert ("desk", "shelf", 25.0, [{"speed": 1.0, "seconds": 25.0}]) == tuple(
        longest[key] for key in ("from", "to", "length", "seconds")
    )
    assert {"lane": ["b", "d"], "share": 0.5} in network["traffic"]["shares"]


@pytest.mark.parametrize(
    "world",
    [
        "{}",
        "waypoints: {a: [0, 0]}",
        "waypoints: {a: [0, 0]}\nplaces: {here: {at: a}}\n".replace("at: a", "at: [0, 0]"),
        "waypoints: {a: [0, 0], b: [1, 0], c: [5, 5], d: [6, 5]}\nlanes: [[a, b], [c, d]]\n",
        "robots: {hawk: {at: [0, 0], base: {flies: true}}}\nplaces: {here: {at: [0, 0]}, there: {at: [3, 4]}}\n",
    ],
    ids=["nothing", "one waypoint", "one place", "two parts", "only a drone"],
)
def test_odd_networks(world, tmp_path, capsys):
    """Worlds without anything to analyze are not errors."""
    path = tmp_path / "odd.yaml"
    path.write_text(f"name: odd\n{world if world != '{}' else ''}")

    assert (0, 0) == (main(["map", "info", str(path)]), main(["map", "info", str(path), "--json"]))
    assert "" == capsys.readouterr().err


def test_the_policy_in_force(info):
    """JSON has its name, and whether it is the default."""
    assert {"policy": "free", "by_default": True} == info["traffic"]


def test_the_policy_in_words(capsys):
    """A line names the policy."""
    main(["map", "info", "cafe"])

    assert "traffic policy: priority" in capsys.readouterr().out.splitlines()
