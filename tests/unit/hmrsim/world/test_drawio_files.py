"""The forms in which draw.io's editors save a drawing."""

from __future__ import annotations

import pytest

from hmrsim.errors import WorldError
from hmrsim.world_checks import load_world
from tests.unit.hmrsim.world.drawings import WALL, diagram, file, model, packed, road, robot, shape, typed

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
    """However it is saved, it is the same drawing."""
    hashes = {}
    for i, (name, text) in enumerate(FORMS.items()):
        path = write("", f"{i}.drawio")
        path.write_bytes(text.encode())
        hashes[name] = load_world(path).hash

    assert hashes == dict.fromkeys(FORMS, hashes["plain"])


@pytest.mark.parametrize("text", [model(*CELLS), file(f"<diagram>{PACKED}</diagram>")])
def test_page_without_a_name_is_called_as_in_the_original(load, text):
    """A bare model, or a diagram without a name."""
    world = load(text, "map.xml").world

    assert world.name == "Window 1"
    assert world.places["bed"].at == (205, 100)


def test_page_without_a_size_is_500_px(load):
    """As in the original."""
    assert load("<mxGraphModel/>", "map.drawio").world.bounds == (0, 0, 500, 500)


@pytest.mark.parametrize(
    "text",
    [
        '<svg xmlns="http://www.w3.org/2000/svg" content="&lt;mxfile/&gt;"/>',
        '<?xml version="1.0"?>\n<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "x.dtd">\n<svg/>',
    ],
)
@pytest.mark.parametrize("name", ["map.drawio.svg", "map.drawio"])
def test_svg_export_is_refused_with_what_would_do(write, text, name):
    """It is a picture, whatever it is called."""
    with pytest.raises(WorldError, match=r"is an SVG picture; open it in draw\.io and save it as \.drawio"):
        load_world(write(text, name))


@pytest.mark.parametrize("name", ["map.drawio.png", "map.PDF"])
def test_picture_is_refused_with_what_would_do(tmp_path, name):
    """Not as a text that can't be decoded."""
    path = tmp_path / name
    path.write_bytes(b"\x89PNG\r\n")

    with pytest.raises(WorldError, match=r"is a picture; open the drawing in draw\.io and save it as \.drawio"):
        load_world(path)


def test_picture_that_is_not_there_is_just_that(tmp_path):
    """No such file."""
    with pytest.raises(WorldError, match="no such file"):
        load_world(tmp_path / "map.png")
