"""The command ``hmrsim map info``."""

from __future__ import annotations

import json

import pytest

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
    file = tmp_path / "islands.yaml"
    file.write_text(WORLD)
    return file


@pytest.fixture
def info(hmrsim):
    def run(path, *options):
        code, out, _ = hmrsim("map info --json", path, *options)
        assert 0 == code
        return json.loads(out)

    return run


def test_json_describes_the_world(info, path):
    info = info(path)
    counts = {"waypoints": 5, "lanes": 2, "docks": 1, "items": 1, "robots": 1}
    none = dict.fromkeys(("walls", "places", "doors", "lifts", "robot_types", "faults"), 0)
    eve = {"name": "eve", "type": "fetcher", "components": ["claw"], "speed": 1.5, "at": [0.0, 0.0], "yaw": 0.0}
    assert counts | none == info["counts"]
    assert (7.0, 1, [2, 2, 1]) == (info["lane_length"], info["one_way_lanes"], info["parts"])
    assert [{**eve, "script": 1}] == info["robots"]
    assert [{"name": "box", "at": [3.0, 4.0], "weight": 2.5}] == info["items"]
    assert ("two islands", str(path), "native", "m") == tuple(info[key] for key in ("name", "file", "format", "units"))
    assert 64 == len(info["hash"])
    assert {"policy": "free", "by_default": True} == info["traffic"]


def test_text_has_the_content_of_json(path, hmrsim):
    lines = hmrsim("map info", path)[1].splitlines()

    assert f"two islands ({path}, native)" == lines[0]
    assert "5 waypoints, 2 lanes, 1 dock, 1 item, 1 robot" in lines
    assert "lanes: 7 m in all, 1 one-way, in 3 parts of 2, 2, 1 waypoints" in lines
    assert "  eve (0, 0) fetcher, 1.5 m/s, claw, a script of 1 line" in lines
    assert "  eve/grab -> eve/pickup" in lines


def test_an_empty_world_has_no_extent(tmp_path, info):
    path = tmp_path / "empty.yaml"
    path.write_text("name: nothing\n")

    assert info(path)["extent"] is None


def test_added_robots_and_items_are_listed(path, info):
    assert ["eve", "bob"] == [robot["name"] for robot in info(path, "--robot", "bob@1,2")["robots"]]


BRIDGE = """\
name: bridge
waypoints: {a: [0, 0], b: [4, 0], c: [4, 3], d: [20, 0], e: [24, 0], f: [24, 3]}
lanes: [[a, b], [b, c], [c, a], [d, e], [e, f], [f, d], {from: b, to: d, one_way: true}]
doors: {gate: {at: [[12, -1], [12, 1]]}}
places: {desk: {at: [0, 0]}, shelf: {at: [24, 3]}}
docks: {plug: {at: c}}
"""


@pytest.fixture
def bridge(tmp_path):
    file = tmp_path / "bridge.yaml"
    file.write_text(BRIDGE)
    return file


def test_the_network_is_printed_as_text(bridge, hmrsim):
    lines = hmrsim("map info", bridge)[1].splitlines()
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


def test_the_network_is_printed_as_json(bridge, info):
    network = info(bridge)["network"]
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
def test_worlds_without_a_network_are_no_errors(world, tmp_path, hmrsim):
    path = tmp_path / "odd.yaml"
    path.write_text(f"name: odd\n{world if world != '{}' else ''}")

    assert [(0, "")] * 2 == [hmrsim(command, path)[::2] for command in ("map info", "map info --json")]


def test_text_names_the_policy(hmrsim):
    assert "traffic policy: priority" in hmrsim("map info cafe")[1].splitlines()
