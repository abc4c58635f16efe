"""Groups, containers and layers of a drawing."""

from __future__ import annotations

from tests.unit.hmrsim.world.drawings import WALL, road, shape, typed


def at(world):
    return {name: place.at for name, place in world.places.items()}


def point(tag: str, x: float, y: float, parent: str) -> str:
    return typed("POI", x, y, 10, 10, tag=tag, id=tag, parent=parent)


def test_a_group_offsets_its_children(draw):
    group = shape("group", 100, 50, 200, 200, id="g")
    wall = shape(WALL, 10, 20, 30, 40, parent="g")
    world = draw(group, wall, point("bed", 50, 60, "g"))

    assert [wall.solid[0] for wall in world.walls] == [(110, 70)]
    assert at(world) == {"bed": (155, 115)}


def test_groups_are_in_groups(draw):
    world = draw(
        point("bed", 1, 2, "inner"), shape("group", 10, 20, 50, 50, id="inner", parent="outer"),
        shape("group", 100, 200, 90, 90, id="outer"),
    )  # fmt: skip

    assert at(world) == {"bed": (116, 227)}


def test_children_of_a_rotated_group_keep_their_positions(draw):
    """The editor already rotates the children in the file."""
    group = shape("group;rotation=90", 100, 100, 200, 100, id="g")
    child = shape(f"{WALL};rotation=90", 50, 45, 100, 10, parent="g")
    (wall,) = draw(group, child).walls

    assert sorted(set(wall.solid)) == [(195, 100), (195, 200), (205, 100), (205, 200)]


def test_containers_offset_their_children(draw):
    lane = shape("swimlane;startSize=23", 100, 100, 200, 200, id="lane", collapsed="1")
    room = shape("shape=mxgraph.floorplan.room;container=1", 300, 100, 100, 100, id="room")
    world = draw(lane, room, point("a", 5, 25, "lane"), point("b", 45, 45, "room"))

    assert at(world) == {"a": (110, 130), "b": (350, 150)}
    assert len(world.walls) == 4


def test_lines_in_a_group_are_placed_by_it(draw):
    group = shape("group", 100, 50, 200, 200, id="g")
    way = road((10, 10), (60, 10), parent="g", target="bed")
    world = draw(group, way, point("bed", 95, 5, "g"))

    assert world.waypoints == {"n1": (110, 60), "n2": (160, 60), "n3": (200, 60)}


def test_relative_children_rotate_with_their_shape(draw):
    place = point("port", 1, 0.5, "s").replace(
        'as="geometry"/>', 'relative="1" as="geometry"><mxPoint x="-5" y="-5" as="offset"/></mxGeometry>'
    )
    straight = draw(shape("group", 100, 100, 100, 50, id="s"), place)
    turned = draw(shape("group;rotation=90", 100, 100, 100, 50, id="s"), place)

    assert (at(straight), at(turned)) == ({"port": (200, 125)}, {"port": (150, 175)})


def test_layers_are_read_and_hidden_ones_are_reported(warned, draw):
    hidden = '<mxCell id="l" parent="0" value="Upper &lt;b&gt;floor&lt;/b&gt;" visible="0"/>'
    other = '<object id="m" label="Notes" owner="me"><mxCell parent="0" visible="0"/></object>'
    bed, table = point("bed", 10, 10, "l"), point("table", 30, 30, "m")

    assert at(draw(hidden, other, bed, table)) == {"bed": (15, 15), "table": (35, 35)}
    assert warned(hidden, other, bed) == [
        "cell 'l' (Upper floor): is a hidden layer, as are 1 more; what is on it is read all the same"
    ]


def test_a_cell_of_a_missing_group_is_on_the_page(draw):
    assert at(draw(point("bed", 10, 10, "nowhere"))) == {"bed": (15, 15)}


def test_groups_inside_each_other_in_a_circle_are_one_error(wrong):
    circle = [shape("group", 1, 1, 9, 9, id=f"g{i}", parent=f"g{(i + 1) % 3}") for i in range(3)]

    assert wrong(point("bed", 1, 1, "g1"), *circle) == [
        "1: POI cell 'bed': is in the group 'g1', which is inside itself; take it out of there"
    ]


def test_cell_in_itself_is_an_error(wrong):
    assert wrong(shape("group", 1, 1, 9, 9, id="g", parent="g")) == [
        "1: cell 'g': is in the group 'g', which is inside itself; take it out of there"
    ]


def test_thousands_of_groups_in_each_other_are_placed(draw):
    groups = [shape("group", 0.5, 0, 9, 9, id=f"g{i}", parent=f"g{i + 1}") for i in range(5000)]

    assert at(draw(point("bed", 0, 0, "g0"), *groups[:-1])) == {"bed": (2504.5, 5)}


def test_error_of_a_group_is_reported_once(wrong):
    group = shape("group", 1, 2, 9, 9, id="g").replace('x="1"', 'x="one"')

    assert wrong(group, point("bed", 1, 1, "g"), point("b", 9, 9, "bed")) == [
        "1: cell 'g': x is 'one'; expected a number of at most 1e+07"
    ]
