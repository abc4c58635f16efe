"""Worlds written as native files."""

from __future__ import annotations

import json

import pytest

from hmrsim.world.writing import native_data, to_json, to_yaml
from hmrsim.world_checks import load_world

TRICKY = """\
name: "yes: # é \\U0001F600 \\u00a0\\x7f 1e3"
units: px
seed: -5
bounds: [-0.0, -1e-7, 123456789e-3, 1e6]
waypoints: {"1e3": [0, 0], "0x1F": [1.5, -0.0], "no": [3, 1e-7], "~": [5, 5], " lead": [7, 7], "a, b]": [8, 8],
  "x: y": [9, 9], "- q": [10, 10], "null": [11, 11], "été": [12, 12], "12:30": [13, 13]}
lanes: [["1e3", "0x1F"], {from: "no", to: "~", one_way: true, speed_limit: 0.5, capacity: 2}]
walls: [[[100, 100], [200, 100]], {solid: [[300, 300], [310, 300], [310, 310]]}]
items: {crate: {at: "no", weight: -0.0}}
robot_types: {t: {base: {speed: 3.0}, components: {claw: {reach: 80.0, max_weight: 1}}}}
robots: {r: {type: t, at: "1e3", yaw: -0.0, base: {speed: null}, components: {claw: {reach: 80}}}, q: {at: [1, 1]}}
faults: [{type: lane_closed, lane: ["1e3", "0x1F"], at: 30.0, until: 60, name: "null"}]
traffic: {policy: free, patience: 1.0}
"""


@pytest.fixture
def load(tmp_path):
    def read(text, suffix=".yaml"):
        path = tmp_path / f"world{suffix}"
        path.write_text(text, encoding="utf-8")
        return load_world(path)

    return read


@pytest.mark.parametrize("source", ["hospital", "scenario1", "scenario2", "tests/unit/hmrsim/world/data/ward.drawio"])
@pytest.mark.parametrize(("write", "suffix"), [(to_yaml, ".yaml"), (to_json, ".json")])
def test_a_written_world_has_the_same_hash(source, write, suffix, load):
    loaded = load_world(source)

    assert loaded.hash == load(write(loaded.world), suffix).hash


@pytest.mark.parametrize(("write", "suffix"), [(to_yaml, ".yaml"), (to_json, ".json")])
def test_odd_names_and_numbers_survive(write, suffix, load):
    loaded = load(TRICKY)

    again = load(write(loaded.world), suffix)
    assert (loaded.hash, loaded.world) == (again.hash, again.world)


def test_a_base_that_resets_a_setting_survives(load):
    """Such a robot has the default speed instead of that of its type."""
    again = load(to_yaml(load(TRICKY).world)).world

    assert again.robot_type(again.robots["r"]).base.speed is None


def test_defaults_are_left_out(load):
    world = load("waypoints: {a: [0, 0], b: [1, 0]}\nlanes: [{from: a, to: b, one_way: false}]\nseed: 0\n").world

    assert {
        "name": "world",
        "units": "m",
        "waypoints": {"a": [0, 0], "b": [1, 0]},
        "lanes": [["a", "b"]],
    } == native_data(world)


def test_yaml_is_laid_out_for_readers(load):
    world = load(
        "name: two rooms\nbounds: [0, 0, 20, 10.5]\nwaypoints: {door: [5, 2], home: [1.0, 2]}\n"
        "lanes: [[home, door]]\nwalls: [{solid: [[1, 5], [2, 5], [2, 6]]}]\n"
        "robots: {eve: {at: home, script: [Go door]}}\n"
    ).world

    assert """\
# yaml-language-server: $schema=../schemas/world.schema.json
name: two rooms
units: m
bounds: [0, 0, 20, 10.5]

waypoints:
  door: [5, 2]
  home: [1, 2]

lanes:
  - [home, door]

walls:
  - solid: [[1, 5], [2, 5], [2, 6]]

robots:
  eve: {at: home, script: [Go door]}
""" == to_yaml(world, schema="../schemas/world.schema.json")


def test_no_line_is_too_long(load):
    corners = ", ".join(f"[{x}.25, {x * x % 97}.5]" for x in range(100))
    world = load(f"walls: [[{corners}]]\n").world

    text = to_yaml(world)
    assert max(map(len, text.splitlines())) <= 110
    assert world == load(text).world


def test_json_has_one_entity_per_line(load):
    text = to_json(load("waypoints: {a: [0, 0], b: [1, 0]}\nlanes: [[a, b]]\n").world)

    assert {"name", "units", "waypoints", "lanes"} == set(json.loads(text))
    assert '    "b": [1, 0]' in text.splitlines()
