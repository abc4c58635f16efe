"""The robots of a drawing: components, scripts and paths."""

from __future__ import annotations

import json

import pytest

from hmrsim.world.files import AS_IT_IS
from hmrsim.world.formats.drawio import FORMAT
from tests.unit.hmrsim.world.drawings import drawing, line, robot, shape, typed

SCRIPT = '[["Go bed", "Wait 2"], 0]'


def read(*cells: str) -> dict:
    """Return the robots of a drawing, before their orders are checked."""
    document = FORMAT.read(drawing(*cells), "map.drawio", AS_IT_IS)
    assert document.findings == ()
    return document.data["robots"]


@pytest.mark.parametrize(
    ("script", "orders"), [(SCRIPT, ["Go bed", "Wait 2"]), ("[]", []), ("[[], 5]", []), ("[[]]", [])]
)
def test_script_becomes_orders(script, orders):
    assert read(robot(component_Script=script))["eve"]["script"] == orders


def test_a_path_is_followed_before_the_script():
    way = line("path", (110.5, 100), (200, 0.125), (200, 150), source="eve", target="bed")
    bed = typed("POI", 245, 145, 10, 10, tag="bed", id="bed")

    assert read(way, robot(component_Script=SCRIPT), bed)["eve"]["script"] == [
        "Follow 110.5 100 200 0.125 200 150 250 150",
        "Go bed",
        "Wait 2",
    ]


def test_paths_are_followed_in_file_order():
    ways = [
        line("path", (i, 0), (i, 9), source=name, identifier=f"p{i}")
        for i, name in enumerate(["eve", "wall_e", "eve"])
    ]  # fmt: skip
    robots = read(*ways, robot(), typed("robot", 200, 200, name="wall_e", id="wall_e"))

    assert robots["eve"]["script"] == ["Follow 0 0 0 9", "Follow 2 0 2 9"]
    assert robots["wall_e"]["script"] == ["Follow 1 0 1 9"]


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("", "has no source; draw it from the robot that is to follow it"),
        ("bed", "has the source 'bed', which is not a robot; draw it from the robot that is to follow it"),
        ("x", "has the source 'x', which is not a shape on this page"),
    ],
)
def test_path_without_a_robot_is_an_error(wrong, source, message):
    cells = (line("path", (0, 0), (9, 9), source=source, identifier="p"), typed("POI", 9, 9, tag="bed", id="bed"))

    assert wrong(*cells) == [f"1: path cell 'p': {message}"]


def test_path_of_a_bad_robot_is_not_reported(wrong):
    cells = (line("path", (0, 0), (9, 9), source="eve", identifier="p"), robot(component_Claw="80"))

    assert wrong(*cells) == ["1: robot cell 'eve': component_Claw is 80; expected a JSON list such as [80, 1]"]


@pytest.mark.parametrize(
    ("attributes", "components"),
    [
        ({"component_Claw": "[60, 2]"}, {"claw": {"reach": 60, "max_weight": 2}}),
        ({"component_Claw": "[60]"}, {"claw": {"reach": 60}}),
        ({"component_Claw": "[]"}, {"claw": {}}),
        ({"component_Battery": "[7200.5, 1, {}]"}, {"battery": {"capacity": 7200.5}}),
        ({"component_Battery": '["x", 5]'}, {"battery": {"capacity": 5}}),
        ({"component_Battery": "[]"}, {"battery": {}}),
        (
            {"battery": '{"initialCharge":5000,"lookupTable":{"default":1,"still":0.5,"moving":2}}'},
            {"battery": {"capacity": 5000, "initial_charge": 5000, "drain": {"default": 1, "still": 0.5, "moving": 2}}},
        ),
        ({"battery": "{}"}, {"battery": {}}),
        (
            {"battery": '{"initialCharge":5}', "component_Battery": "[9]"},
            {"battery": {"capacity": 9, "initial_charge": 5}},
        ),
        ({"collision_tag": "stopEvent", "movable": "true"}, {}),
    ],
)
def test_components_become_our_settings(draw, attributes, components):
    assert draw(robot(**attributes)).robots["eve"].components == components


def test_speeds_of_old_maps_are_per_frame(draw):
    base = draw(robot(speed="5")).robots["eve"].base

    assert (base.speed, base.radius) == (300, 15)


def test_all_errors_of_a_robot_are_reported_at_once(wrong):
    bad = robot(component_Claw="[80", component_Script="[[1], 0]", component_Battery='["full"]', speed="fast").replace(
        'x="85"', 'x="left"'
    )

    assert wrong(bad) == [
        f"1: robot cell 'eve': {message}"
        for message in (
            "x is 'left'; expected a number of at most 1e+07",
            "speed is 'fast'; expected a number of at most 1e+07",
            'component_Script is [[1], 0]; expected [["Go place", …], 0]',
            "component_Claw is '[80'; expected JSON such as [80, 1]",
            "component_Battery is ['full']; expected its capacity, such as [3600]",
        )
    ]


@pytest.mark.parametrize(
    ("attribute", "text", "message"),
    [
        ("component_Script", '"Go"', "is 'Go'; expected a JSON list such as [[\"Go place\"], 0]"),
        ("component_Script", '["Go bed", 0]', "is ['Go bed', 0]; expected [[\"Go place\", …], 0]"),
        ("component_Script", '[["Go bed"], "x"]', "has ['x'] after its orders; expected a number"),
        ("component_Script", "[" * 100_000, "is '[["),
        ("component_Claw", "[NaN]", "is '[NaN]'; expected JSON such as [80, 1]"),
        ("component_Claw", "[1, 2, 3]", "has 3 arguments; expected at most 2: reach, max_weight"),
        ("battery", "5000", 'is 5000; expected JSON such as {"initialCharge": 5000'),
        ("battery", '{"lookupTable": 5}', "is a mapping; expected JSON such as"),
        ("battery", "{", "is '{'; expected JSON such as {"),
    ],
)
def test_attribute_that_is_invalid_is_an_error(wrong, attribute, text, message):
    (error,) = wrong(robot(**{attribute: text}))

    assert error.startswith(f"1: robot cell 'eve': {attribute} {message}")


@pytest.mark.parametrize(
    ("attributes", "error"),
    [
        ({"component_Claw": "[-80, 1]"}, "robots.eve.components.claw.reach: must be greater than 0, got -80"),
        ({"speed": "-5"}, "robot cell 'eve': speed is '-5'; expected a number above 0, in px a frame"),
        (
            {"battery": '{"lookupTable": {"still": "much"}}'},
            "robots.eve.components.battery.drain.still: expected a number, got 'much'",
        ),
    ],
)
def test_settings_are_checked_as_in_any_world(wrong, attributes, error):
    assert wrong(robot(**attributes)) == [f"1: {error}"]


def test_charge_above_the_capacity_is_an_error(wrong):
    (error,) = wrong(robot(battery='{"initialCharge":9}', component_Battery="[5]"))

    assert "initial_charge 9 is more than the capacity 5" in error


def test_omitted_parts_are_warnings(warned):
    way = line("path", (0, 0), (1, 1), source="eve", identifier="p")
    empty = way[: way.index("<mxPoint")] + way[way.index("</mxGeometry>") :]

    assert warned(robot(component_Laser="[1]", movable="false", label="&lt;b&gt;Eve&lt;/b&gt;"), empty) == [
        "robot cell 'eve' (Eve): component_Laser is not known here and left out",
        "robot cell 'eve' (Eve): movable is 'false'; robots can always move here",
        "path cell 'p': has no points, so there is nothing to follow",
    ]


def test_robots_without_a_name_are_numbered(draw):
    world = draw(*(typed("robot", x, 50, id=f"r{x}", name=name) for x, name in ((10, ""), (60, "robot_2"), (110, ""))))

    assert {name: robot.at[0] for name, robot in world.robots.items()} == {"robot_1": 25, "robot_2": 75, "robot_3": 125}


def test_an_invalid_name_has_its_place(wrong):
    (error,) = wrong(robot("wall e"))

    assert error.startswith("1: robots.wall e: ")


def test_attributes_are_written_as_the_editor_writes_them():
    cell = robot(component_Script=json.dumps([["Go bed"], 0], indent=1)).replace("\n", "&#10;")

    assert read(cell, shape("text", 1, 1, 1, 1))["eve"]["script"] == ["Go bed"]
