"""Obstacles that the shapes of a drawing cover."""

from __future__ import annotations

import math

import pytest

from hmrsim.geometry import Obstacles
from tests.unit.hmrsim.world.drawings import CORNER, ROOM, WALL, WALL_U, shape, typed


def spans(world):
    return [
        tuple(round(edge(point[i] for point in wall.solid), 3) for edge in (min, max) for i in (0, 1))
        for wall in world.walls
    ]


@pytest.mark.parametrize(
    ("style", "boxes"),
    [
        (WALL, [(100, 100, 200, 160)]),
        (f"{WALL};direction=south", [(100, 100, 200, 160)]),
        (f"{WALL};rotation=-90", [(120, 80, 180, 180)]),
        (f"{WALL};rotation=270.0;", [(120, 80, 180, 180)]),
        ("rounded=0", [(100, 100, 200, 160)]),
        ("shape=mxgraph.floorplan.doorLeft", [(100, 100, 200, 160)]),
        ("shape=image;image=data:image/png,abc", [(100, 100, 200, 160)]),
        (WALL_U, [(100, 100, 110, 160), (100, 100, 200, 110), (190, 100, 200, 160)]),
        (CORNER, [(100, 100, 110, 160), (100, 100, 200, 110)]),
        (f"{CORNER};direction=east", [(100, 100, 110, 160), (100, 100, 200, 110)]),
        (f"{CORNER};direction=north", [(100, 100, 110, 160), (100, 150, 200, 160)]),
        (f"{CORNER};direction=south", [(100, 100, 200, 110), (190, 100, 200, 160)]),
        (f"{CORNER};direction=west", [(190, 100, 200, 160), (100, 150, 200, 160)]),
        (f"{CORNER};wallThickness=20", [(100, 100, 120, 160), (100, 100, 200, 120)]),
        (ROOM, [(100, 100, 110, 160), (100, 100, 200, 110), (190, 100, 200, 160), (100, 150, 200, 160)]),
        ("ellipse", [(100, 100, 200, 160)]),
    ],
)
def test_shape_covers_its_bars(draw, style, boxes):
    assert boxes == spans(draw(shape(style, 100, 100, 100, 60)))


@pytest.mark.parametrize(
    ("style", "error"),
    [
        ("wallThickness=-4", "wallThickness is '-4'; expected a number above 0, such as 10"),
        ("wallThickness=0", "wallThickness is '0'; expected a number above 0, such as 10"),
        ("wallThickness=thin", "wallThickness is 'thin'; expected a number of at most 1e+07"),
        ("direction=up", "direction is 'up'; expected one of east, south, west, north"),
    ],
)
def test_walls_that_are_invalid_are_reported(wrong, style, error):
    assert [f"1: cell 'w': {error}"] == wrong(shape(f"{ROOM};{style}", 100, 100, 100, 60, id="w"))


def test_walls_thicker_than_their_box_are_warned_of(warned):
    (warning,) = warned(shape(f"{ROOM};wallThickness=500", 100, 100, 100, 60, id="w"))

    assert "cell 'w': wallThickness is 500, more than its size of 100 x 60, so it is solid" == warning


@pytest.mark.parametrize(
    "style", ["text;html=1", "shape=text", "edgeLabel", "group", "swimlane;startSize=23", "rounded=0;container=1", ""]
)
def test_decorations_are_no_obstacles(draw, style):
    assert draw(shape(style, 100, 100, 100, 60)).walls == ()


def test_untyped_line_is_decoration(draw):
    arrow = (
        '<mxCell id="a" style="edgeStyle=none" edge="1" parent="1"><mxGeometry relative="1" as="geometry"/></mxCell>'
    )
    label = shape("rounded=0", 0, 0, 50, 20, parent="a")

    assert draw(arrow, label).walls == ()


ASIDE = {"left": (-80, 0), "top": (0, -80), "right": (80, 0), "bottom": (0, 80)}


def ways_out(world):
    """Return the sides to which a robot can leave the middle of a shape around (150, 150)."""
    obstacles = Obstacles([], [wall.solid for wall in world.walls])
    return " ".join(side for side, (x, y) in ASIDE.items() if not obstacles.block((150, 150), (150 + x, 150 + y)))


@pytest.mark.parametrize(
    ("style", "gaps"),
    [
        (WALL_U, {0: "bottom", 90: "left", 180: "top", 270: "right", -90: "right", 450: "left"}),
        (f"{WALL_U};direction=south", {0: "left", 90: "top", 180: "right", -90: "bottom"}),
        (f"{WALL_U};direction=west", {0: "top", 90: "right"}),
        (f"{WALL_U};direction=north", {0: "right", 90: "bottom"}),
        (f"{WALL_U};flipV=1", {0: "top", 90: "right", 180: "bottom", 270: "left"}),
        (f"{WALL_U};flipH=1", {0: "bottom", 90: "left"}),
        (f"{WALL_U};direction=south;flipH=1", {0: "right", 90: "bottom"}),
        (CORNER, {0: "right bottom", 90: "left bottom", 180: "left top", 270: "top right"}),
        (f"{CORNER};direction=north", {0: "top right", 90: "right bottom", 180: "left bottom", 270: "left top"}),
        (f"{CORNER};direction=south", {0: "left bottom", 90: "left top", 180: "top right", 270: "right bottom"}),
        (f"{CORNER};direction=west", {0: "left top", 90: "top right", 180: "right bottom", 270: "left bottom"}),
        (f"{CORNER};flipH=1", {0: "left bottom", 90: "left top"}),
        (f"{CORNER};flipH=1;flipV=1", {0: "left top"}),
        (f"{CORNER};flipH=0", {0: "right bottom"}),
        (ROOM, {0: "", 30: "", 90: ""}),
    ],
)
def test_a_drawn_gap_is_passable(draw, style, gaps):
    shapes = {turn: draw(shape(f"{style};rotation={turn}", 100, 100, 100, 100)) for turn in gaps}

    assert gaps == {turn: ways_out(world) for turn, world in shapes.items()}


def test_oblique_u_opens_between_the_sides(draw):
    world = draw(shape(f"{WALL_U};rotation=45", 100, 100, 100, 100))
    obstacles = Obstacles([], [wall.solid for wall in world.walls])

    assert not obstacles.block((150, 150), (90, 210))
    assert obstacles.block((150, 150), (210, 210))


@pytest.mark.parametrize(
    ("cell", "boxes"),
    [
        (shape(WALL_U, 100, 100, 6, 4), [(100, 100, 106, 104)] * 3),
        (shape(f"{WALL};rotation=90;", -81.25, 218.75, 212.5, 10), [(20, 117.5, 30, 330)]),
        (shape(WALL, 0, 0, 60, 0).replace(' x="0" y="0"', "").replace(' height="0"', ""), [(0, 0, 60, 1)]),
    ],
    ids=["bars no thicker than their box", "a rotated wall", "missing numbers are 0, and walls 1 px thin"],
)
def test_shapes_are_where_the_original_has_them(draw, cell, boxes):
    assert spans(draw(cell)) == boxes


def test_walls_rotate_clockwise(draw):
    (wall,) = draw(shape(f"{WALL};rotation=30", 100, 100, 200, 0)).walls

    assert [(round(x, 2), round(y, 2)) for x, y in wall.solid] == [
        (113.65, 50.07),
        (286.85, 150.07),
        (286.35, 150.93),
        (113.15, 50.93),
    ]


def test_an_ellipse_has_its_exact_center(draw):
    (wall,) = draw(shape("ellipse;rotation=180", 100, 100, 11, 5)).walls

    assert {round(((x - 105.5) / 5.5) ** 2 + ((y - 102.5) / 2.5) ** 2, 4) for x, y in wall.solid} == {1.0}
    assert len(wall.solid) == 24


def test_an_ellipse_is_rotated(draw):
    (wall,) = draw(shape("ellipse;rotation=30", 100, 100, 100, 20)).walls
    end = (150 + 50 * math.cos(math.pi / 6), 110 + 50 * math.sin(math.pi / 6))

    assert [(round(end[0], 6), round(end[1], 6))] == [point for point in wall.solid if math.dist(point, end) < 1]


def test_shape_without_a_size_is_reported(warned):
    assert warned(shape("rounded=0", 1, 1, 0, 5, id="s")) == ["cell 's': has the size 0 x 5, so it is not an obstacle"]


def test_named_point_is_where_the_original_has_it(draw):
    world = draw(typed("POI", 512.5, 10, 12, 13, tag="a"))

    assert world.places["a"].at == (518.5, 16)
