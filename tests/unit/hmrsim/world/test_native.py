"""Native world files: YAML, and JSON."""

from __future__ import annotations

import json

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from hmrsim.documents import yaml_text
from hmrsim.errors import WorldError
from hmrsim.world.formats.native import FORMAT
from tests.profiles import examples


def test_the_documented_example_loads(load):
    world = load(EXAMPLE).world

    assert (world.name, len(world.lanes), sorted(world.robots)) == ("two rooms", 2, ["eve", "wall_e"])


def test_json_is_read(load):
    text = json.dumps({"name": "ward \U0001f916", "waypoints": {"a": [1, 2]}}, indent="\t")

    assert load(text, "world.json").world.name == "ward \U0001f916"


@pytest.mark.parametrize("text", ["1e-3", "1E-3", "0.001", ".001", "+1.0e-03"])
def test_number_is_written_as_in_yaml_1_2(text):
    """In YAML 1.1, 1e-3 is text."""
    assert FORMAT.read(f"seed: {text}", "x").data == {"seed": 0.001}


@pytest.mark.parametrize("text", ["yes", "no", "on", "0b1", "1_000", "12:30", "2001-01-01", "'1'", "!!str 1"])
def test_words_of_yaml_1_1_are_text(text):
    value = FORMAT.read(f"name: {text}", "x").data["name"]

    assert isinstance(value, str)


@pytest.mark.parametrize(
    ("text", "waypoints"),
    [("{7: [0, 0]}", {"7": [0, 0]}), ("{a: &here [1, 2], b: *here}", {"a": [1, 2], "b": [1, 2]})],
    ids=["a number as a key is a name", "an alias stands for its anchor"],
)
def test_keys_are_names_and_aliases_are_replaced(text, waypoints):
    assert FORMAT.read(f"waypoints: {text}", "x").data == {"waypoints": waypoints}


def test_lines_are_those_of_the_keys():
    document = FORMAT.read("name: x\nrobots:\n  r:\n    at:\n      [0,\n 0]\n", "x")

    paths = [("name",), ("robots", "r"), ("robots", "r", "at"), ("robots", "r", "at", 1), ("robots", "r", "yaw")]
    assert [document.line(path) for path in paths] == [1, 3, 4, 6, 3]


def test_duplicate_key_is_an_error_with_both_lines(errors_of):
    assert errors_of("name: a\nseed: 1\nname: b\n") == ["3: name: key 'name' is there twice, first in line 1; keep one"]


NINE = ", ".join("*{0}" for _ in range(9))
BOMB = "a0: &a0 [x]\n" + "".join(f"a{i}: &a{i} [{NINE.format(f'a{i - 1}')}]\n" for i in range(1, 40))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is empty"),
        ("[1, 2]", r":1: expected a mapping with keys such as .*, got \[1, 2\]"),
        ("a: [1\nb: 2", ":2: is not valid YAML: "),
        ("a: 1\n---\nb: 1", ":2: has more than one document"),
        ("a: !!python/object:os.system x", ":1: has the tag"),
        ("a: !!timestamp 2001-01-01", ":1: has the tag"),
        ("? [a]\n: b", ":1: has a mapping or list as a key"),
        ("a: &a [*a]", ":1: alias 'a' is inside what it stands for"),
        ("a: 1\n\tb: 2", ":2: is not valid YAML: there is a tab in column 1; indent with spaces"),
        ("a:\n  b: 1\n \tc: 2", ":3: is not valid YAML: there is a tab in column 2; indent with spaces"),
        ("a:\n-\tb: 1", ":2: is not valid YAML: there is a tab in column 2; indent with spaces"),
        ("a: {\n\tb: @c}", ":2: is not valid YAML: '@' in column 5 can't begin a value; put the value in quotes"),
        ("a: *b", ":1: is not valid YAML|:1: alias 'b' stands for nothing"),
        ("a: " + "[" * 100_000, ":1: is nested deeper than 50"),
        ("a: " + "{a: " * 100_000, ":1: is nested deeper than 50"),
        ("- " * 100_000, ":1: is nested deeper than 50"),
        (BOMB, "has more than 500000 values, aliases written out"),
        ("a: \x00", "is not valid YAML"),
    ],
    ids=lambda value: repr(value[:20]),
)
def test_hostile_or_broken_text_is_one_error(text, message):
    with pytest.raises(WorldError, match=message) as caught:
        FORMAT.read(text, "file")

    assert len(caught.value.problems) == 1


def test_text_of_too_many_values_is_one_error(monkeypatch):
    """Values of aliases count as well."""
    monkeypatch.setattr(yaml_text, "MAX_NODES", 100)
    with pytest.raises(WorldError, match=":1: has more than 100 values") as caught:
        FORMAT.read("a: [" + "0," * 100 + "0]", "file")

    assert len(caught.value.problems) == 1


@pytest.mark.parametrize("text", [".nan", "-.inf", ".INF", "1e999", "9" * 5000])
def test_nan_infinity_and_huge_numbers_are_rejected(errors_of, text):
    (error,) = errors_of(f"waypoints:\n  a: [{text}, 0]\n")

    assert error.startswith("2: waypoints.a.0: ")


@given(st.text(max_size=200) | st.binary(max_size=200).map(lambda data: data.decode("latin-1")))
@examples(300)
@example("a: &x\nb: *x")
@example("&x : *x")
@example("? &a a\n: *a")
def test_any_text_is_a_document_or_an_error(text):
    try:
        document = FORMAT.read(text, "x")
    except WorldError:
        return
    assert isinstance(document.data, dict)


EXAMPLE = """\
# yaml-language-server: $schema=../schemas/world.schema.json
name: two rooms
units: m
bounds: [0, 0, 20, 10]
waypoints: {door: [5, 2], shelf: [9, 2], home: [1, 2]}
lanes:
  - [home, door]
  - {from: door, to: shelf, one_way: true, speed_limit: 0.5, capacity: 1}
walls: [[[0, 0], [20, 0], [20, 10], [0, 10], [0, 0]]]
places: {pharmacy: {at: [9, 2.4]}}
docks: {charger: {at: [1, 1], type: charger, capacity: 1}}
items: {medicine: {at: [9, 2.3], weight: 0.2}}
robot_types:
  nurse: {base: {speed: 0.8}, components: {claw: {reach: 0.9, max_weight: 1.0}, battery: {capacity: 3600}}}
robots:
  wall_e: {type: nurse, at: [1, 2], yaw: 0, script: [Go pharmacy, Grab medicine, Go home, Drop medicine]}
  eve: {type: nurse, at: home, planner: external}
traffic: {policy: free}
faults: [{type: lane_closed, lane: [home, door], at: 30, until: 60}]
remap: {navigate_to_pose/wall_e: wall_e/navigate_to_pose, wall_e/grab: wall_e/pickup, wall_e/drop: wall_e/place}
seed: 7
"""
