"""The draw.io maps of the original."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from hmrsim.errors import WorldError
from hmrsim.graph import WaypointGraph
from hmrsim.world import load_world

if TYPE_CHECKING:
    from types import ModuleType

HERE = Path(__file__).parent
REFERENCE = HERE.parents[1].parent / "shared" / "data" / "drawio"


def _module(name: str) -> ModuleType:
    """Import a module beside this one; tests are no package."""
    spec = importlib.util.spec_from_file_location(name, HERE / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


_drawings = _module("drawings")
drawing, pack, packed_bytes = _drawings.drawing, _drawings.pack, _drawings.packed_bytes
shape, typed, road = _drawings.shape, _drawings.typed, _drawings.road

WALL = "shape=mxgraph.floorplan.wall"


@pytest.fixture
def draw(load):
    """Loads a drawing with these cells."""
    return lambda *cells: load(drawing("".join(cells)), "map.drawio").world


@pytest.fixture
def wrong(errors_of):
    """Returns the errors of a drawing with these cells."""
    return lambda *cells: errors_of(drawing("".join(cells)), "map.drawio")


def spans(world):
    """Return the box around each solid."""
    return [
        tuple(round(edge(point[i] for point in wall.solid), 3) for edge in (min, max) for i in (0, 1))
        for wall in world.walls
    ]


@pytest.fixture(scope="module")
def ward():
    """A drawing with all that the original's maps use."""
    return load_world(HERE / "data" / "ward.drawio").world


# --- the fixture as a whole ---------------------------------------------------------------------------------------


def test_page_is_the_world(ward):
    """The page's name and size; pixels."""
    assert (ward.name, ward.units, ward.bounds) == ("Ward", "px", (0, 0, 600, 400))


def test_shapes_are_solids_and_text_is_none(ward):
    """Walls, turned about their centre; three bars of a U; a table and a pillar; no text and no arrow."""
    assert spans(ward) == [
        (0, 10, 600, 20),
        (295, 100, 305, 300),
        (450, 250, 550, 260),
        (540, 250, 550, 350),
        (450, 340, 550, 350),
        (40, 40, 100, 60),
        (150, 300, 170, 320),
    ]


def test_things_are_at_their_centre(ward):
    """Half of a size is rounded down: 12 px at 62.5 have their centre at 68.5."""
    assert ward.items["syrup"].at == (68.5, 49.0)
    assert {name: place.at for name, place in ward.places.items()} == {"bed": (100, 350), "POI_1": (400, 80)}


def test_robots_have_claw_script_and_name(ward):
    """Components are settings of ours; who has no name is numbered."""
    eve, other = ward.robots["eve"], ward.robots["robot_1"]

    assert (eve.at, eve.components) == ((500, 80), {"claw": {"reach": 60, "max_weight": 2}})
    assert (other.at, other.components, other.script) == ((100, 100), {}, ("Go bed", "Go 450 80"))


def test_roads_are_waypoints_and_lanes(ward):
    """Roads begin and end at the shapes that they are tied to, and connect where they cross or nearly touch."""
    assert ward.waypoints == {
        "n1": (500, 80),
        "n2": (480, 80),
        "n3": (400, 80),
        "n4": (200, 80),
        "n5": (100, 80),
        "n6": (100, 100),
        "n7": (200, 60),
        "n8": (200, 340),
        "n9": (200, 350),
        "n10": (185, 340),
        "n11": (120, 340),
    }
    assert [(lane.from_, lane.to) for lane in ward.lanes] == [
        ("n1", "n2"),
        ("n2", "n3"),
        ("n3", "n4"),
        ("n4", "n5"),
        ("n5", "n6"),
        ("n7", "n4"),
        ("n4", "n8"),
        ("n8", "n9"),
        ("n10", "n11"),
        ("n10", "n8"),
    ]


def test_compressed_file_is_the_same_world(ward, load):
    """Deflated, percent-encoded and in base64, broken into lines, or without any <mxfile>: all the same."""
    text = (HERE / "data" / "ward.drawio").read_text(encoding="utf-8")
    model = text[text.index("<mxGraphModel") : text.index("</diagram>")]
    packed = pack(model)

    assert load(packed, "ward.xml").world == ward
    assert load(packed.replace("</diagram>", "\n</diagram>\n"), "ward.drawio").world == ward
    assert load(model, "bare.drawio").world.model_copy(update={"name": "Ward"}) == ward


# --- shapes -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("style", "boxes"),
    [
        (WALL, [(100, 100, 200, 160)]),
        (f"{WALL};rotation=-90", [(120, 80, 180, 180)]),
        ("rounded=0", [(100, 100, 200, 160)]),
        ("shape=mxgraph.floorplan.doorLeft", [(100, 100, 200, 160)]),
        (
            "shape=mxgraph.floorplan.wallU",
            [(100, 100, 110, 160), (100, 100, 200, 110), (190, 100, 200, 160)],
        ),
        ("shape=mxgraph.floorplan.wallCorner", [(100, 100, 110, 160), (100, 100, 200, 110)]),
        ("shape=mxgraph.floorplan.wallCorner;direction=north", [(100, 100, 110, 160), (100, 150, 200, 160)]),
        ("shape=mxgraph.floorplan.wallCorner;direction=south", [(190, 100, 200, 160), (100, 100, 200, 110)]),
        ("shape=mxgraph.floorplan.wallCorner;direction=west", [(190, 100, 200, 160), (100, 150, 200, 160)]),
        (
            "shape=mxgraph.floorplan.room",
            [(100, 100, 110, 160), (100, 100, 200, 110), (190, 100, 200, 160), (100, 150, 200, 160)],
        ),
        ("ellipse", [(100, 100, 200, 160)]),
        ("text;html=1", []),
        ("shape=text", []),
        ("edgeLabel", []),
    ],
)
def test_shape_covers_its_bars(draw, style, boxes):
    """Each shape of the floor plan library, and what is none."""
    assert spans(draw(shape(style, 100, 100, 100, 60))) == boxes


def test_oblique_wall_is_turned_clockwise(draw):
    """30 degrees clockwise on screen: the right end of the wall goes down."""
    (wall,) = draw(shape(f"{WALL};rotation=30", 100, 100, 200, 0)).walls

    assert [(round(x, 2), round(y, 2)) for x, y in wall.solid] == [
        (113.65, 50.07),
        (286.85, 150.07),
        (286.35, 150.93),
        (113.15, 50.93),
    ]


def test_children_of_a_group_are_inside_it(draw):
    """A group is no obstacle; what is in it is placed from its corner."""
    group = shape("group", 100, 50, 200, 200, id="g")
    inner = shape("rounded=0", 10, 20, 30, 40).replace('parent="1"', 'parent="g"')

    assert spans(draw(group, inner)) == [(110, 70, 140, 110)]


# --- roads --------------------------------------------------------------------------------------------------------


def lanes(world):
    """Return the points that lanes join."""
    return [(world.waypoints[lane.from_], world.waypoints[lane.to]) for lane in world.lanes]


def test_crossing_roads_connect(draw):
    """A waypoint stands where two roads cross."""
    world = draw(road((0, 100), (200, 100)), road((100, 0), (100, 200)))

    assert lanes(world) == [
        ((0, 100), (100, 100)),
        ((100, 100), (200, 100)),
        ((100, 0), (100, 100)),
        ((100, 100), (100, 200)),
    ]


def test_overlapping_roads_are_one(draw):
    """What is drawn twice is there once."""
    world = draw(road((0, 100), (200, 100)), road((150, 100), (300, 100)))

    assert lanes(world) == [((0, 100), (150, 100)), ((150, 100), (200, 100)), ((200, 100), (300, 100))]


@pytest.mark.parametrize(("end", "linked"), [(119, True), (120, True), (221, False)])
def test_end_near_a_road_connects_there(draw, end, linked):
    """Within 20 px of a road an end connects to the nearest point of it; beyond 100 px it does not."""
    world = draw(road((0, 100), (200, 100)), road((100, 300), (100, end)))

    assert (((100, end), (100, 100)) in lanes(world)) == linked


def test_parts_apart_are_linked_by_their_nearest_points(draw):
    """Two roads 100 px apart are linked."""
    world = draw(road((0, 100), (200, 100)), road((300, 150), (300, 50)))

    assert lanes(world)[-1] == ((200, 100), (300, 100))


def test_parts_farther_apart_are_not_linked(draw):
    """Two roads 101 px apart remain so."""
    assert len(draw(road((0, 100), (200, 100)), road((301, 150), (301, 50))).lanes) == 2


def test_parts_are_not_linked_through_a_wall(draw):
    """A wall between two parts keeps them apart, and a link goes where there is none."""
    wall = shape(WALL, 245, 0, 10, 150)
    one, two = road((200, 20), (200, 130)), road((300, 20), (300, 130))

    assert len(draw(wall, one, two).lanes) == 2
    assert ((200, 180), (300, 180)) in lanes(draw(wall, road((200, 20), (200, 180)), road((300, 20), (300, 180))))


def test_waypoints_take_no_name_of_a_place(draw):
    """A POI that is called n1 keeps its name."""
    world = draw(typed("POI", 10, 10, 10, 10, tag="n1"), road((0, 100), (200, 100)))

    assert sorted(world.waypoints) == ["n2", "n3"]


# --- what can't be understood -------------------------------------------------------------------------------------


def test_all_bad_cells_are_told_at_once(wrong):
    """Each cell is named, with its line."""
    errors = wrong(
        typed("drone", 1, 1, 1, 1, id="d"),
        typed("", 1, 1, 1, 1, id="t"),
        typed("pickable", 1, 1, 1, 1, id="p"),
        typed("pickable", 1, 1, 1, 1, id="w", name="cup", weight="heavy"),
        typed("robot", 1, 1, 30, 30, id="r", component_Claw="[80"),
        typed("robot", 1, 1, 30, 30, id="q", component_Claw="[80, 1, 2]"),
        typed("robot", 1, 1, 30, 30, id="c", component_Script="[[1], 0]"),
        typed("robot", 50, 50, 30, 30, id="e", name="eve"),
        typed("robot", 50, 50, 30, 30, id="f", name="eve"),
        road((0, 0), (1, 1), identifier="m", ends='source="nobody"'),
    )

    assert errors == [
        "1: drone cell 'd': has the unknown type 'drone'; there are robot, pickable, POI, map-path, path, debug",
        "1: cell 't': has no type; expected one of robot, pickable, POI, map-path, path, debug",
        "1: pickable cell 'p': has no name; items are picked up by it",
        "1: pickable cell 'w': weight is 'heavy'; expected a number of at most 1e+07",
        "1: robot cell 'r': component_Claw is '[80'; expected a JSON list such as [80, 1]",
        "1: robot cell 'q': component_Claw has 3 arguments; expected at most 2: reach, max_weight",
        "1: robot cell 'c': component_Script is [[1], 0]; expected [[\"Go place\", …], 0]",
        "1: robot cell 'f': is another one named 'eve'; give it a name of its own",
        "1: map-path cell 'm': has the source 'nobody', which is no shape on this page",
    ]


@pytest.mark.parametrize("number", ["nan", "inf", "-Infinity", "1e300", "1e8", "ten", "", "1e9999"])
def test_absurd_coordinate_is_refused(wrong, number):
    """NaN, infinity and absurd sizes."""
    (error,) = wrong(typed("POI", 1, 2, 3, 4, id="p").replace('x="1"', f'x="{number}"'))

    assert error == f"1: POI cell 'p': x is {number!r}; expected a number of at most 1e+07"


def test_bad_setting_of_a_claw_is_told_at_its_robot(wrong):
    """The settings of a component are checked as in any other world."""
    (error,) = wrong(typed("robot", 1, 1, 30, 30, name="eve", component_Claw="[-80, 1]"))

    assert error == "1: robots.eve.components.claw.reach: must be greater than 0, got -80"


def test_what_is_left_out_is_a_warning(load):
    """A component that we don't know, a way that a robot follows by itself, a shape without a size."""
    cells = (
        typed("robot", 1, 1, 30, 30, id="r", component_Laser="[1]")
        + typed("path", 1, 1, 1, 1, id="p")
        + shape("rounded=0", 1, 1, 0, 5)
    )

    assert [str(warning).partition(": ")[2] for warning in load(drawing(cells), "map.drawio").warnings] == [
        "robot cell 'r': component_Laser is not known here and left out",
        "path cell 'p': is a way that a robot follows by itself, which is not known here and left out",
        "cell 's': has the size 0 x 5, so it is no obstacle",
    ]


LAUGHS = '<!DOCTYPE x [<!ENTITY a "ha"><!ENTITY b "&a;&a;">]>'


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (f"{LAUGHS}<mxfile>&b;</mxfile>", "has a DOCTYPE"),
        ('<!DOCTYPE mxfile SYSTEM "file:///etc/passwd"><mxfile/>', "has a DOCTYPE"),
        ("<mxfile>&b;</mxfile>", "is no XML: undefined entity"),
        ("<mxfile>", "is no XML: no element found"),
        ("<mxfile/>", "has no <diagram>"),
        ("<mxfile><diagram/></mxfile>", "has an empty <diagram>"),
        ("<mxfile><diagram>%%%</diagram></mxfile>", "is no base64"),
        ("<mxfile><diagram>AAAA</diagram></mxfile>", "can't be inflated|cut off"),
        ("<mxfile><diagram><svg/></diagram></mxfile>", "has no <mxGraphModel>"),
        ("<?xml version='1.0'?><svg/>", "begins with <svg>; expected <mxfile> or <mxGraphModel>"),
        ("<mxfile>" + "<a>" * 1000, "is nested deeper than 100"),
        ("<mxfile>" + "<a/>" * 200_001 + "</mxfile>", "has more than 200000 elements"),
        (packed_bytes(b"a" * (33 * 1024 * 1024)), "has a compressed <diagram> of more than 32 MiB"),
        (packed_bytes(f"{LAUGHS}<mxGraphModel/>".encode()), "has a DOCTYPE"),
        (packed_bytes(b"\xff\xfe"), "is not UTF-8"),
        (packed_bytes(b"%FF"), "is not UTF-8"),
        (packed_bytes(b"hello"), "is no XML: syntax error"),
        (packed_bytes(b"<mxGraphModel/>")[:-30] + "</diagram></mxfile>", "cut off|is no base64|can't be inflated"),
    ],
    ids=lambda value: repr(value[:40]),
)
def test_hostile_or_broken_file_is_one_error(write, text, message):
    """Entities, bombs and rubbish are refused, before they cost anything."""
    with pytest.raises(WorldError, match=message) as caught:
        load_world(write(text, "map.drawio"))

    assert len(caught.value.problems) == 1


def test_too_many_roads_are_refused(wrong):
    """All pieces are compared with all others, so there is a limit."""
    (error,) = wrong(road(*((i % 2, i % 300) for i in range(2002))))

    assert error == "1: lanes: 2001 pieces of road; at most 2000"


# --- the original's own maps, where they are ----------------------------------------------------------------------


@pytest.mark.skipif(not REFERENCE.is_dir(), reason="the original's maps are not here; they are under the GPL")
@pytest.mark.parametrize(
    ("name", "start", "goals"),
    [
        ("hospital", (515, 80), [(519.5, 245), (75, 225), (500, 80)]),
        ("place_with_walls", (515, 80), [(512, 215), (100, 180)]),
        ("poi_test", (78, 86), [(450, 330), (78, 38), (292, 38), (518, 38), (78, 358), (518, 358)]),
    ],
)
def test_original_map_can_be_driven(name, start, goals):
    """Its robot is where it was, and reaches what it reached."""
    world = load_world(REFERENCE / f"{name}.drawio").world
    (robot,) = world.robots.values()
    graph = WaypointGraph(world)

    assert robot.at == start
    assert [graph.plan(robot.at, goal, 300.0).length > 0.0 for goal in goals] == [True] * len(goals)
