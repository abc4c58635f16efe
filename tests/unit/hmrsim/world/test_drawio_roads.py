"""The roads of a drawing."""

from __future__ import annotations

import pytest

from hmrsim.world.formats import _drawio_roads
from tests.unit.hmrsim.world.drawings import WALL, line, road, robot, shape, typed


def lanes(world):
    return [(world.waypoints[lane.from_], world.waypoints[lane.to]) for lane in world.lanes]


def test_crossing_roads_connect(draw):
    world = draw(road((0, 100), (200, 100)), road((100, 0), (100, 200)))

    assert lanes(world) == [
        ((0, 100), (100, 100)),
        ((100, 100), (200, 100)),
        ((100, 0), (100, 100)),
        ((100, 100), (100, 200)),
    ]


def test_overlapping_roads_are_one(draw):
    world = draw(road((0, 100), (200, 100)), road((150, 100), (300, 100)))

    assert lanes(world) == [((0, 100), (150, 100)), ((150, 100), (200, 100)), ((200, 100), (300, 100))]


@pytest.mark.parametrize(("end", "linked"), [(119, True), (120, True), (221, False)])
def test_end_near_a_road_connects_there(draw, end, linked):
    world = draw(road((0, 100), (200, 100)), road((100, 300), (100, end)))

    assert (((100, end), (100, 100)) in lanes(world)) == linked


@pytest.mark.parametrize(("x", "links"), [(300, [((200, 100), (300, 100))]), (301, [])])
def test_parts_at_most_100_px_apart_are_linked_by_their_nearest_points(draw, x, links):
    world = draw(road((0, 100), (200, 100)), road((x, 150), (x, 50)))

    assert [lane for lane in lanes(world) if lane[0] == (200, 100)] == links


def test_parts_are_not_linked_through_a_wall(draw):
    wall = shape(WALL, 245, 0, 10, 150)
    one, two = road((200, 20), (200, 130)), road((300, 20), (300, 130))

    assert len(draw(wall, one, two).lanes) == 2
    assert ((200, 180), (300, 180)) in lanes(draw(wall, road((200, 20), (200, 180)), road((300, 20), (300, 180))))


def test_waypoints_take_no_name_of_a_place(draw):
    world = draw(typed("POI", 10, 10, 10, 10, tag="n1"), road((0, 100), (200, 100)))

    assert sorted(world.waypoints) == ["n2", "n3"]


def test_road_joins_the_shapes_at_its_ends(draw):
    way = road((110, 100), (190, 100), source="eve", target="bed")
    world = draw(way, robot(), typed("POI", 205, 95, 10, 10, tag="bed", id="bed"))

    assert list(world.waypoints.values()) == [(100, 100), (110, 100), (190, 100), (210, 100)]


def test_missing_points_are_left_out(draw):
    cell = road((7, 7), (8, 8), source="eve", target="bed").replace('as="sourcePoint"', 'as="offset"')
    cell = cell.replace('<mxPoint x="8" y="8" as="targetPoint"/>', "")
    world = draw(robot(), typed("POI", 205, 95, 10, 10, tag="bed", id="bed"), cell)

    assert lanes(world) == [((100, 100), (210, 100))]


def test_missing_coordinates_are_0(draw):
    assert lanes(draw(road((0, 30), (50, 0)).replace(' x="0"', "").replace(' y="0"', ""))) == [((0, 30), (50, 0))]


def test_road_without_points_is_reported(warned):
    assert warned(road((5, 5), (5, 5), identifier="r")) == [
        "map-path cell 'r': has fewer than two points, so it is not a road"
    ]


@pytest.mark.parametrize(
    ("cells", "message"),
    [
        ([road((0, 0), (1, 1), source="nobody")], "has the source 'nobody', which is not a shape on this page"),
        ([road((0, 0), (1, 1), target="1")], "has the target '1', which is not a shape on this page"),
        ([road((0, 0), (1, 1), target="r")], "has the target 'r', which is not a shape on this page"),
        ([road((0, 0), ("nan", 1))], "x is 'nan'; expected a number of at most 1e+07"),
        ([typed("map-path", 1, 1)], "is a shape; a map-path is a line"),
    ],
)
def test_road_that_is_invalid_is_an_error(wrong, cells, message):
    cells = [cell.replace("map-path1-1", "r") for cell in cells]
    (error,) = wrong(road((50, 50), (60, 60), identifier="r") if "'r'" in message else "", *cells)

    assert error.startswith("1: map-path cell ")
    assert error.endswith(f": {message}")


def test_a_road_to_an_invalid_shape_is_not_reported(wrong):
    bed = typed("POI", 1, 1, tag="bed", id="bed").replace('x="1"', 'x="?"')

    assert wrong(road((0, 0), (1, 1), target="bed"), bed) == [
        "1: POI cell 'bed': x is '?'; expected a number of at most 1e+07"
    ]


def test_too_many_roads_are_rejected(wrong):
    """Each piece is compared with all others."""
    (error,) = wrong(road(*((i % 2, i % 300) for i in range(2002))))

    assert error == "1: lanes: 2001 pieces of road; at most 2000"


def test_too_many_links_between_walls_are_rejected(wrong, monkeypatch):
    monkeypatch.setattr(_drawio_roads, "_MAX_COMPARISONS", 10_000)
    walls = [shape(WALL, 0, y / 5, 600, 0.04, id=f"w{y}") for y in range(1000)]
    roads = [road((x * 2, y), (x * 2, y + 1), identifier=f"r{x}-{y}") for x in range(30) for y in (5, 95)]

    assert wrong(*walls, *roads) == [
        "1: lanes: too many roads near each other with too many walls between; connect the roads"
    ]


def test_a_robot_s_path_is_no_road(draw):
    assert draw(typed("POI", 1, 1, tag="bed"), road((0, 0), (9, 0))).lanes != ()
    assert draw(robot(), line("path", (100, 100), (100, 150), source="eve")).lanes == ()
