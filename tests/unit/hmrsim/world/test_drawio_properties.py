"""Properties that hold for all drawings."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from hmrsim.errors import WorldError
from hmrsim.world.files import AS_IT_IS
from hmrsim.world.formats.drawio import FORMAT
from tests.profiles import examples
from tests.unit.hmrsim.world.drawings import (
    CORNER,
    ROOM,
    WALL,
    WALL_U,
    diagram,
    drawing,
    file,
    model,
    packed,
    road,
    shape,
    typed,
)

numbers = st.integers(-400, 4000).map(lambda n: n / 4)
sizes = st.integers(0, 800).map(lambda n: n / 4)
turns = st.integers(-360, 360)
labels = st.text(st.characters(codec="utf-8", exclude_categories=["Cs", "Cc"]), max_size=10)
styles = st.sampled_from(
    [WALL, WALL_U, CORNER, ROOM, "rounded=0", "ellipse", "text", f"{CORNER};direction=north", f"{WALL_U};flipV=1"]
)


@st.composite
def shapes(draw):
    kind = draw(st.sampled_from(["shape", "POI", "road"]))
    identifier = f"c{draw(st.integers(0, 10**9))}"
    x, y, width, height = draw(numbers), draw(numbers), draw(sizes), draw(sizes)
    if kind == "POI":
        label = draw(labels)
        return lambda dx, dy, parent: typed(
            "POI", x + dx, y + dy, width, height, tag=identifier, id=identifier, label=label, parent=parent
        )
    if kind == "road":
        return lambda dx, dy, parent: road(
            (x + dx, y + dy), (x + width + dx, y + height + dy), identifier=identifier, parent=parent
        )
    style = f"{draw(styles)};rotation={draw(turns)}"
    return lambda dx, dy, parent: shape(style, x + dx, y + dy, width, height, id=identifier, parent=parent)


drawings = st.lists(shapes(), max_size=6)


def read(text: str) -> dict:
    return FORMAT.read(text, "map.drawio", AS_IT_IS).data


@given(drawings)
@examples(60)
def test_a_compressed_drawing_equals_the_plain_one(cells):
    content = model(*(cell(0, 0, "1") for cell in cells))

    assert read(file(diagram(content))) == read(file(diagram(packed(content))))


@given(styles, numbers, numbers, sizes, sizes, turns)
@examples(60)
def test_a_full_turn_changes_nothing(style, x, y, width, height, turn):
    once, again = (
        read(drawing(shape(f"{style};rotation={degrees}", x, y, width, height))) for degrees in (turn, turn + 360)
    )

    assert once == again


@given(drawings, numbers, numbers, turns)
@examples(60)
def test_a_group_equals_its_moved_children(cells, x, y, turn):
    group = shape(f"group;rotation={turn}", x, y, 50, 50, id="g")
    grouped = read(drawing(group, *(cell(0, 0, "g") for cell in cells)))

    assert grouped == read(drawing(*(cell(x, y, "1") for cell in cells)))


@given(st.text(max_size=100) | st.binary(max_size=100).map(packed))
@examples(200)
def test_any_text_is_a_document_or_an_error(text):
    for whole in (text, file(diagram(text)), f"<mxGraphModel><root>{text}</root></mxGraphModel>"):
        try:
            assert FORMAT.read(whole, "x", AS_IT_IS).pages
        except WorldError as error:
            assert error.problems  # noqa: PT017  # either will do


@given(st.dictionaries(st.sampled_from(["type", "id", "name", "battery", "speed", "component_Script"]), labels))
@examples(100)
def test_any_attribute_gives_a_document(attributes):
    cell = typed("robot", 1, 1, **attributes)

    assert isinstance(FORMAT.read(drawing(cell), "x", AS_IT_IS).data["robots"], dict)
