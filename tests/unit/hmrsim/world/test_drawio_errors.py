"""Drawings that are wrong, broken or hostile."""

from __future__ import annotations

from contextlib import suppress

import pytest

from hmrsim.errors import WorldError
from hmrsim.world import ReadOptions
from hmrsim.world.formats import _drawio_cells
from hmrsim.world_checks import load_world
from tests.calls import calls_of
from tests.unit.hmrsim.world.drawings import diagram, drawing, file, model, packed, road, robot, shape, typed

LENIENT = ReadOptions(lenient=True)
TYPES = "robot, pickable, POI, map-path, path, debug"


def test_all_bad_cells_are_reported_at_once(wrong):
    errors = wrong(
        road((0, 0), (1, 1), identifier="m", source="nobody"),
        shape("rounded=0;rotation=steep", 1, 1, 1, 1, id="s", value="&lt;b&gt;A &amp;amp; B&lt;/b&gt;"),
        typed("drone", 1, 1, id="d", label="Hawk"),
        typed("", 1, 1, id="t"),
        typed("pickable", 1, 1, id="p"),
        typed("pickable", 1, 1, id="w", name="cup", weight="heavy"),
        typed("robot", 50, 50, id="e", name="eve"),
        typed("robot", 50, 50, id="f", name="eve"),
        typed("POI", 50, 50, id="e", tag="bed"),
        typed("POI", 1, 1, id="-").replace("<mxGeometry", "<mxWrong"),
        typed("POI", 1, 1, id="l", parent="m"),
        typed("robot", 1, 1, id="edge").replace('vertex="1"', 'edge="1"'),
        shape("rounded=0", 1, 1, -5, 1, id="n"),
    )

    assert errors == [
        "1: POI cell 'e': has an id that another cell has; draw.io gives every cell its own",
        "1: cell 's' (A & B): rotation is 'steep'; expected a number of at most 1e+07",
        "1: cell 'n': has the size -5 x 1; expected none below 0",
        f"1: drone cell 'd' (Hawk): has the unknown type 'drone'; there are {TYPES}; --lenient leaves it out",
        f"1: cell 't': has no type; expected one of {TYPES}; --lenient leaves it out",
        "1: pickable cell 'p': has no name; items are picked up by it",
        "1: pickable cell 'w': weight is 'heavy'; expected a number of at most 1e+07",
        "1: robot cell 'f': is another one named 'eve'; give it a name of its own",
        "1: POI cell '-': has no mxGeometry, so it is nowhere",
        "1: POI cell 'l': is a label of the line 'm'; put it on the page",
        "1: robot cell 'edge': is a line; a robot is a shape",
        "1: map-path cell 'm': has the source 'nobody', which is not a shape on this page",
    ]


@pytest.mark.parametrize(
    ("cell", "error"),
    [
        ('<object type="robot" name="q" id="z" label=""/>', "robot cell 'z': has no mxGeometry, so it is nowhere"),
        ('<object type="map-path" id="z" label=""/>', "map-path cell 'z': has no mxGeometry, so it is nowhere"),
        (
            '<UserObject id="z" label="q"/>',
            f"cell 'z' (q): has no type; expected one of {TYPES}; --lenient leaves it out",
        ),
    ],
)
def test_object_without_a_cell_is_reported(wrong, cell, error):
    assert [f"1: {error}"] == wrong(cell)


@pytest.mark.parametrize(
    ("cell", "warning"),
    [
        (
            '<mxCell id="v" style="rounded=0" vertex="1" parent="1"/>',
            "cell 'v': has no mxGeometry, so it is nowhere and left out",
        ),
        (
            typed("POI", 1, 1, id="p", parent="nope"),
            "POI cell 'p': is in 'nope', which is not a cell of this page; it is placed on the page itself",
        ),
    ],
)
def test_cells_without_a_position_are_warned_of(warned, cell, warning):
    assert [warning] == warned(cell)


def test_all_numbers_of_a_cell_are_reported(wrong):
    cell = shape("rounded=0;rotation=steep", 1, 2, 3, 4, id="s").replace('x="1"', 'x="NaN"').replace('"4"', '"tall"')

    assert [
        "1: cell 's': x is 'NaN'; expected a number of at most 1e+07",
        "1: cell 's': height is 'tall'; expected a number of at most 1e+07",
        "1: cell 's': rotation is 'steep'; expected a number of at most 1e+07",
    ] == wrong(cell)


@pytest.mark.parametrize(
    ("cell", "value"),
    [
        (typed("POI", 1, 2, id="p").replace('x="1"', 'x="NaN"'), "NaN"),
        (typed("drone", 1, 2), "drone"),
        (road((0, 0), (1, 1), source="nobody"), "nobody"),
        (robot(speed="-5"), "-5"),
        (robot(component_Claw='["a", 1, 2]'), ["a", 1, 2]),
        (typed("pickable", 1, 1), None),
    ],
)
def test_problem_has_the_value_that_is_invalid(write, cell, value):
    with pytest.raises(WorldError, match="cell") as caught:
        load_world(write(drawing(cell), "map.drawio"))

    assert [value] == [problem.value for problem in caught.value.problems]


def test_lines_are_reported_in_plain_files(errors_of):
    text = drawing(typed("drone", 1, 1, id="a"), typed("robo", 1, 1, id="b")).replace("<object", "\n<object")

    assert [error[:20] for error in errors_of(text, "map.drawio")] == ["2: drone cell 'a': h", "3: robo cell 'b': ha"]


def test_a_misspelled_type_gets_a_suggestion(wrong):
    (error,) = wrong(typed("robo", 1, 1, id="r"))

    assert error == "1: robo cell 'r': has the unknown type 'robo'; did you mean 'robot'?; --lenient leaves it out"


def test_errors_that_may_follow_from_an_invalid_cell_are_omitted(write):
    write(drawing(robot(speed="x")), "map.drawio")
    world = write("include: [map.drawio]\nremap: {eve/grab: eve/pickup}\nlanes: [[a, b]]\n")

    with pytest.raises(WorldError) as caught:
        load_world(world)

    assert ["robot cell 'eve'"] == [problem.path for problem in caught.value.problems]


def test_unknown_types_are_left_out_when_asked(write):
    cells = (
        typed("drone", 100, 100, id="d"),
        typed("", 200, 200, id="t"),
        road((0, 115), (60, 115), target="d"),
        road((0, 50), (9, 50)).replace("map-path", "canal").replace('id="', 'id="c'),
    )
    loaded = load_world(write(drawing(*cells), "map.drawio"), options=LENIENT)

    assert [str(warning).partition(": ")[2] for warning in loaded.warnings][:2] == [
        "drone cell 'd': has the unknown type 'drone'; it is left out",
        "cell 't': has no type; it is left out",
    ]
    assert len(loaded.warnings) == 3
    assert loaded.world.walls == ()
    assert loaded.world.waypoints["n3"] == (115, 115)


def test_lenient_keeps_other_errors(write):
    with pytest.raises(WorldError, match="weight is 'x'"):
        load_world(write(drawing(typed("pickable", 1, 1, name="a", weight="x")), "map.drawio"), options=LENIENT)


@pytest.mark.parametrize("number", ["nan", "inf", "-Infinity", "1e300", "1e8", "ten", "", "1e9999", "0x10", "1_0"])
def test_absurd_coordinates_are_rejected(wrong, number):
    (error,) = wrong(typed("POI", 1, 2, id="p").replace('x="1"', f'x="{number}"'))

    assert error == f"1: POI cell 'p': x is {number!r}; expected a number of at most 1e+07"


@pytest.mark.parametrize("attribute", ["pageWidth", "pageHeight"])
def test_an_absurd_page_size_is_rejected(errors_of, attribute):
    (error,) = errors_of(file(diagram(f'<mxGraphModel {attribute}="wide"/>')), "map.drawio")

    assert error == f"1: bounds: {attribute} is 'wide'; expected a number of at most 1e+07"


LAUGHS = '<!DOCTYPE x [<!ENTITY a "ha"><!ENTITY b "&a;&a;">]>'


def page(content: str | bytes) -> str:
    return file(diagram(packed(content)))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (f"{LAUGHS}<mxfile>&b;</mxfile>", "has a DOCTYPE"),
        ('<!DOCTYPE mxfile SYSTEM "file:///etc/passwd"><mxfile/>', "has a DOCTYPE"),
        ("<mxfile>&b;</mxfile>", "is not valid XML: undefined entity"),
        ("<mxfile>", "is not valid XML: no element found"),
        ("<mxfile/>", "has no <diagram>"),
        ("<mxfile><diagram/></mxfile>", "has an empty <diagram>"),
        ("<mxfile><diagram>%%%</diagram></mxfile>", "is not valid base64"),
        ("<mxfile><diagram>AAAA</diagram></mxfile>", "can't be inflated|cut off"),
        ("<mxfile><diagram><svg/></diagram></mxfile>", "has no <mxGraphModel>"),
        ("<?xml version='1.0'?><html/>", "begins with <html>; expected <mxfile> or <mxGraphModel>"),
        ("<mxfile>" + "<a>" * 1000, "is nested deeper than 100"),
        (drawing("<mxCell/>" * 10_001), "has 10003 cells on a page; at most 10000"),
        (page(b"a" * (33 * 1024 * 1024)), "has a compressed <diagram> of more than 32 MiB"),
        (page(f"{LAUGHS}<mxGraphModel/>".encode()), "has a DOCTYPE"),
        (page(b"\xff\xfe"), "is not UTF-8"),
        (page(b"%FF"), "is not UTF-8"),
        (page(b"hello"), "is not valid XML: syntax error"),
        (file(diagram(packed(model())[:-12])), "cut off|is not valid base64|can't be inflated"),
    ],
    ids=lambda value: repr(value[:40]),
)
def test_hostile_or_broken_file_is_one_error(write, text, message):
    with pytest.raises(WorldError, match=message) as caught:
        load_world(write(text, "map.drawio"))

    assert len(caught.value.problems) == 1


def test_file_of_too_many_elements_is_one_error(write, monkeypatch):
    monkeypatch.setattr(_drawio_cells, "MAX_ELEMENTS", 100)
    with pytest.raises(WorldError, match="has more than 100 elements") as caught:
        load_world(write("<mxfile>" + "<a/>" * 101 + "</mxfile>", "map.drawio"))

    assert len(caught.value.problems) == 1


CROWDS = {
    "walls": [shape("rounded=0", i % 90 * 5, i // 90 * 3, 4, 4, id=f"w{i}") for i in range(4_950)],
    "circles": [shape("group", 1, 1, 9, 9, id=f"g{i}", parent=f"g{(i + 1) % 4_950}") for i in range(4_950)],
    "unknown": [typed("robo", 1, 1, id=f"r{i}") for i in range(4_950)],
    "roads": [road((0, y * 2), (500, y * 2), identifier=f"a{y}") for y in range(85)]
    + [road((x * 4, 0), (x * 4, 300), identifier=f"b{x}") for x in range(85)],
    "labels": [shape("text", 1, 1, 9, 9, id=f"t{i}", value="&lt;" * 100_000) for i in range(20)],
}


@pytest.mark.parametrize("cells", CROWDS.values(), ids=CROWDS)
def test_many_cells_are_not_compared_with_all_others(write, cells):
    """Five thousand cells have twelve million pairs."""
    path = write(drawing(*cells), "map.drawio")

    def load():
        with suppress(WorldError):
            load_world(path)

    assert calls_of(load) < 5_000_000
