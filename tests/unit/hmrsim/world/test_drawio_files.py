"""The forms in which draw.io saves a drawing, its pages, and new names for its robots."""

from __future__ import annotations

import argparse

import pytest

from hmrsim.cli.options import add_world_options
from hmrsim.cli.worlds import read_world
from hmrsim.errors import WorldError
from hmrsim.world import ReadOptions
from hmrsim.world_checks import load_world
from tests.unit.hmrsim.world.drawings import (
    WALL,
    diagram,
    drawing,
    file,
    line,
    model,
    packed,
    road,
    robot,
    shape,
    typed,
)

CELLS = (
    shape(WALL, 0, 10, 600, 10),
    robot(label='<b style="x">M&uuml;ller &amp; 30 % + ½</b>', component_Claw="[60, 2]"),
    typed("POI", 200, 95, 10, 10, tag="bed", id="bed"),
    road((120, 100), (190, 100), source="eve", target="bed"),
)
PLAIN = file(diagram(model(*CELLS), "Ward"))
PACKED = packed(model(*CELLS))
WEB = (
    '<mxfile host="app.diagrams.net" modified="2026-01-01T00:00:00.000Z" agent="Mozilla/5.0" etag="a-b_c"'
    ' version="24.7.17" type="device">'
)

FORMS = {
    "plain": PLAIN,
    "compressed": file(diagram(PACKED, "Ward")),
    "compressed with line feeds": file(diagram(f"\n  {PACKED[:76]}\r\n{PACKED[76:]}\n", "Ward")),
    "web": PLAIN.replace('<mxfile host="test">', WEB).replace("<diagram ", '<diagram id="x-y_z" '),
    "declared": f'<?xml version="1.0" encoding="UTF-8"?>\n<!-- drawn by hand -->\n{PLAIN}\n',
    "byte order mark": f"\ufeff{PLAIN}",
    "indented, CRLF": PLAIN.replace("><", ">\r\n\t<"),
    "comments": PLAIN.replace("<root>", "<!-- here --><root><!-- cells -->"),
    "UserObject": PLAIN.replace("<object", "<UserObject").replace("</object", "</UserObject"),
    "placeholders": PLAIN.replace('label=""', 'label="%name%" placeholders="1"'),
    "second page": file(diagram(model(*CELLS), "Ward"), diagram("rubbish", "Notes")),
}


def test_forms_are_the_same_world(write):
    hashes = {}
    for i, (name, text) in enumerate(FORMS.items()):
        path = write("", f"{i}.drawio")
        path.write_bytes(text.encode())
        hashes[name] = load_world(path).hash

    assert hashes == dict.fromkeys(FORMS, hashes["plain"])


@pytest.mark.parametrize("text", [model(*CELLS), file(f"<diagram>{PACKED}</diagram>")])
def test_page_without_a_name_is_called_as_in_the_original(load, text):
    world = load(text, "map.xml").world

    assert world.name == "Window 1"
    assert world.places["bed"].at == (205, 100)


def test_page_without_a_size_is_500_px(load):
    assert load("<mxGraphModel/>", "map.drawio").world.bounds == (0, 0, 500, 500)


@pytest.mark.parametrize(
    "text",
    [
        '<svg xmlns="http://www.w3.org/2000/svg" content="&lt;mxfile/&gt;"/>',
        '<?xml version="1.0"?>\n<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "x.dtd">\n<svg/>',
    ],
)
@pytest.mark.parametrize("name", ["map.drawio.svg", "map.drawio"])
def test_svg_export_is_rejected_with_a_remedy(write, text, name):
    with pytest.raises(WorldError, match=r"is an SVG picture; open it in draw\.io and save it as \.drawio"):
        load_world(write(text, name))


@pytest.mark.parametrize("name", ["map.drawio.png", "map.PDF"])
def test_picture_is_rejected_with_a_remedy(tmp_path, name):
    path = tmp_path / name
    path.write_bytes(b"\x89PNG\r\n")

    with pytest.raises(WorldError, match=r"is a picture; open the drawing in draw\.io and save it as \.drawio"):
        load_world(path)


def test_a_missing_picture_is_a_missing_file(tmp_path):
    with pytest.raises(WorldError, match="no such file"):
        load_world(tmp_path / "map.png")


PAGES = file(
    diagram(model(typed("POI", 0, 0, tag="ground")), "Ground"),
    diagram(packed(model(typed("POI", 0, 0, tag="upper"))), "Upper"),
    diagram(model(typed("POI", 0, 0, tag="one")), "1"),
)
ROBOTS = drawing(robot(), typed("robot", 200, 100, id="r"), typed("robot", 300, 100, id="q"))


def load(path, *, page=None, **rename):
    return load_world(path, options=ReadOptions(page=page, rename=rename)).world


@pytest.mark.parametrize(
    ("page", "place"), [(None, "ground"), ("Upper", "upper"), ("2", "upper"), ("1", "one"), ("3", "one")]
)
def test_page_is_chosen_by_name_or_number(write, page, place):
    """A native file that includes a drawing passes the page on."""
    drawn = write(PAGES, "map.drawio")

    assert [[place]] * 2 == [list(load(path, page=page).places) for path in (drawn, write("include: [map.drawio]\n"))]


@pytest.mark.parametrize("page", ["4", "0", "-1", "upper", "", "9" * 5000])
def test_unknown_page_is_an_error(write, page):
    with pytest.raises(WorldError, match=r"has no page '.*'; there are 1 \(Ground\), 2 \(Upper\), 3 \(1\)"):
        load(write(PAGES, "map.drawio"), page=page)


def test_page_without_a_drawing_is_an_error(write):
    with pytest.raises(WorldError, match="--page 2: there are no pages; drawings have them, and levels and"):
        load(write("name: x\n"), page="2")


def test_robots_are_renamed(write):
    text = ROBOTS.replace("</root>", line("path", (200, 100), (200, 150), source="r") + "</root>")
    world = load(write(text, "map.drawio"), robot_1="eve", eve="wall_e")

    assert {name: robot.at[0] for name, robot in world.robots.items()} == {"wall_e": 100, "eve": 215, "robot_2": 315}
    assert world.robots["eve"].script == ("Follow 200 100 200 150",)


def test_robots_of_an_included_drawing_are_renamed(write):
    write(ROBOTS, "map.drawio")
    world = load(write("include: [map.drawio]\nremap: {x/y: wall_e/navigate_to_pose}\n"), robot_2="wall_e")

    assert list(world.robots) == ["eve", "robot_1", "wall_e"]


@pytest.mark.parametrize(
    ("rename", "message"),
    [
        ({"robot_3": "x"}, "--rename robot_3=x: no robot 'robot_3' of a drawing to rename; did you mean 'robot_2'"),
        ({"nobody": "x"}, "--rename nobody=x: no robot 'nobody' of a drawing to rename; there are eve, robot_1"),
        ({"robot_1": "eve"}, "robot cell 'r': can't be renamed to 'eve', which another robot is called"),
        ({"eve": "robot_1"}, "robot cell 'r': is another one named 'robot_1'; give it a name of its own"),
        ({"eve": "9"}, "robots.9: "),
    ],
)
def test_rename_that_is_invalid_is_an_error(write, rename, message):
    with pytest.raises(WorldError, match=message.replace("(", r"\(")):
        load(write(ROBOTS, "map.drawio"), **rename)


def test_new_name_that_the_native_file_has_is_an_error(write):
    write(ROBOTS, "map.drawio")

    with pytest.raises(WorldError, match=r"'wall_e' is in .*world.yaml already"):
        load(write("include: [map.drawio]\nrobots: {wall_e: {at: [9, 9]}}\nunits: px\n"), robot_1="wall_e")


def command(*arguments: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    add_world_options(parser)
    return parser.parse_args(arguments)


def test_command_line_has_the_options(write):
    pages = file(diagram(model(), "Ground"), diagram(model(typed("robot", 1, 1), typed("drone", 9, 9)), "Upper"))
    loaded = read_world(
        command(str(write(pages, "map.drawio")), "--page", "Upper", "--rename", "robot_1=wall_e", "--lenient")
    )

    assert list(loaded.world.robots) == ["wall_e"]


@pytest.mark.parametrize(
    ("texts", "message"),
    [
        (["eve"], "--rename eve: expected OLD=NEW"),
        (["=x"], "--rename =x: expected OLD=NEW"),
        (["eve=9x"], "--rename eve=9x: expected OLD=NEW"),
        (["eve=_x"], "--rename eve=_x: expected OLD=NEW"),
        (["eve=a", "eve=b"], "--rename eve=b: 'eve' is renamed to 'a' already"),
    ],
)
def test_bad_rename_on_the_command_line_is_an_error(write, texts, message):
    options = [part for text in texts for part in ("--rename", text)]

    with pytest.raises(WorldError, match=message):
        read_world(command(str(write(ROBOTS, "map.drawio")), *options))
