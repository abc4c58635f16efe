"""Worlds as pictures."""

from __future__ import annotations

import itertools
from time import process_time
from xml.etree import ElementTree as ET

import pytest

from hmrsim.drawing import PALETTE, THEMES, Drawing, type_looks
from hmrsim.drawing.labels import Labels
from hmrsim.world import World
from hmrsim.world.files import shipped_maps
from tests.shipped import shipped

MAPS = sorted(shipped_maps())
SVG = "{http://www.w3.org/2000/svg}"
HOSTILE = "<img src=x onerror=alert(1)> & \"'\x00\x1b]]>"

TWO_ROOMS = World.model_validate(
    {
        "name": "two rooms",
        "bounds": [0, 0, 20, 10],
        "waypoints": {"a": [1, 2], "b": [9, 2], "c": [9, 8]},
        "lanes": [["a", "b"], {"from": "b", "to": "c", "one_way": True, "speed_limit": 0.5, "capacity": 2}],
        "walls": [[[5, 0], [5, 1]], [[5, 3], [5, 10]], {"solid": [[12, 1], [14, 1], [14, 3]]}],
        "places": {"desk": {"at": [3, 8]}},
        "docks": {"plug": {"at": [1, 5], "type": "charger"}, "ramp": {"at": [19, 5]}},
        "doors": {"gate": {"at": [[5, 1], [5, 3]]}},
        "lifts": {"tower": {"stops": ["a", "c"]}},
        "items": {"box": {"at": "desk", "weight": 2}},
        "robot_types": {"drone": {"base": {"flies": True, "radius": 0.5}}},
        "robots": {
            "eve": {"at": "b", "yaw": 1.5707963267948966},
            "wall_e": {"type": "drone", "at": [16, 8]},
        },
    }
)


def drawn(world, theme="light", **options):
    """Return the picture of a world, as a tree of elements."""
    return ET.fromstring(Drawing(world, theme, **options).svg())


def layer(picture, name):
    """Return the elements of one layer."""
    return list(next(group for group in picture.iter(f"{SVG}g") if group.get("class") == name))


def texts(picture):
    """Return all that is written."""
    return [element.text for element in picture.iter(f"{SVG}text")]


@pytest.mark.parametrize(
    ("name", "number"),
    [
        ("walls", 2),
        ("solids", 1),
        ("lanes", 2),
        ("waypoints", 3),
        ("places", 1),
        ("docks", 2),
        ("doors", 1),
        ("lifts", 2),
        ("items", 1),
        ("robots", 2),
    ],
)
def test_everything_is_drawn_once(name, number):
    """Each entity is one element of its layer, and a lift is one for each of its stops."""
    assert number == len(layer(drawn(TWO_ROOMS), name))


@pytest.mark.parametrize("theme", THEMES)
@pytest.mark.parametrize("name", MAPS)
def test_shipped_worlds(name, theme):
    """Every shipped world is well-formed SVG with all its lanes and robots."""
    world = shipped(name).world
    picture = drawn(world, theme)

    assert len(world.robots) == len(layer(picture, "robots"))
    assert len(world.lanes) == len(layer(picture, "lanes"))


def test_the_same_world_is_the_same_picture():
    """Drawing a world twice gives the same bytes."""
    assert Drawing(TWO_ROOMS).svg() == Drawing(TWO_ROOMS.model_copy(deep=True)).svg()


def test_meters_point_up():
    """In meters, greater y is further up."""
    low, _, high = layer(drawn(TWO_ROOMS), "waypoints")

    assert float(low.get("cy")) > float(high.get("cy"))


def test_pixels_point_down():
    """In pixels, greater y is further down."""
    low, _, high = layer(drawn(TWO_ROOMS.model_copy(update={"units": "px"})), "waypoints")

    assert float(low.get("cy")) < float(high.get("cy"))


@pytest.mark.parametrize(("units", "ahead"), [("m", -1), ("px", 1)])
def test_robots_point_ahead(units, ahead):
    """A yaw of half pi points to greater y: up in meters, down in pixels."""
    eve = layer(drawn(TWO_ROOMS.model_copy(update={"units": units})), "robots")[0]

    assert f"rotate({90 * ahead})" in eve.get("transform")


def test_things_are_where_they_are():
    """A point in the middle of the bounds is in the middle of the floor."""
    drawing = Drawing(TWO_ROOMS)
    floor = next(element for element in drawn(TWO_ROOMS).iter(f"{SVG}rect") if element.get("class") == "floor")
    x, y, width, height = (float(floor.get(key)) for key in ("x", "y", "width", "height"))

    assert (x + width / 2, y + height / 2) == pytest.approx(drawing.frame.at((10, 5)))
    assert width == pytest.approx(2 * height)


def test_the_first_type_is_yellow():
    """Robots have the color and shape of their type, and the first robot is a yellow cart."""
    shapes = PALETTE["bodies"]["types"]
    looks = {"carrier": ("#f5c400", shapes[0]), "drone": ("#4cbefc", shapes[1])}
    assert looks == type_looks(TWO_ROOMS)
    bodies = [
        [(part.get("fill"), part.get("d")) for part in robot.iter(f"{SVG}path")]
        for robot in layer(drawn(TWO_ROOMS, legend=False), "robots")
    ]
    assert [look in drawn_as for look, drawn_as in zip(looks.values(), bodies, strict=True)] == [True, True]


def test_only_a_robot_that_flies_has_rotors():
    """Only a flying robot has rotors, four of them."""
    eve, drone = layer(drawn(TWO_ROOMS), "robots")

    assert (0, 4) == (len(list(eve.iter(f"{SVG}circle"))), len(list(drone.iter(f"{SVG}circle"))))


def test_a_one_way_lane_has_an_arrow():
    """A one-way lane has two strokes, other lanes one."""
    both, one_way = layer(drawn(TWO_ROOMS), "lanes")

    assert (1, 2) == (both.get("d").count("M"), one_way.get("d").count("M"))


def test_what_is_pointed_at_is_explained():
    """The tooltip of a lane has its ends, speed limit and capacity."""
    _, one_way = layer(drawn(TWO_ROOMS), "lanes")

    assert "b → c, ≤ 0.5 m/s, 2 at once" == one_way[0].text


def test_details_are_written():
    """Speed limits and capacities are shown on request only."""
    assert "≤ 0.5 m/s, 2 at once" in texts(drawn(TWO_ROOMS, details=True))
    assert "≤ 0.5 m/s, 2 at once" not in texts(drawn(TWO_ROOMS))


def test_names_can_be_left_out():
    """Without names and legend there is no text."""
    assert {"eve", "wall_e", "desk", "plug", "gate", "tower", "box"} <= set(texts(drawn(TWO_ROOMS)))
    assert [] == texts(drawn(TWO_ROOMS, names=False, legend=False))


def test_the_legend_has_what_there_is():
    """The legend explains exactly the drawn marks."""
    world = World.model_validate({"waypoints": {"a": [0, 0], "b": [5, 0]}, "lanes": [["a", "b"]]})

    assert ["0.5 m", "world", "1 lane", "lane"] == [text for text in texts(drawn(world)) if text not in "ab"]


@pytest.mark.parametrize("name", MAPS)
def test_names_do_not_overlap(name):
    """Names don't overlap, assuming a wide font."""
    boxes = []
    for text in drawn(shipped(name).world).findall(f"{SVG}g[@class='names']/{SVG}text"):
        size, x, y = (float(text.get(key)) for key in ("font-size", "x", "y"))
        half = len(text.text) * size * 0.3
        boxes.append((x - half, y - size * 0.8, x + half, y + size * 0.2))

    assert [] == [
        (a, b)
        for a, b in itertools.combinations(boxes, 2)
        if a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]
    ]


def test_hostile_names_are_text():
    """Names are shown literally and never become elements."""
    world = TWO_ROOMS.model_copy(update={"name": HOSTILE, "places": {HOSTILE: TWO_ROOMS.places["desk"]}})
    picture = drawn(world.model_copy(update={"items": {}}))
    shown = "<img src=x onerror=alert(1)> & \"'\ufffd\ufffd]]>"

    assert shown == picture.find(f"{SVG}title").text == layer(picture, "places")[0][0].text
    assert not list(picture.iter(f"{SVG}img"))


def test_a_picture_loads_nothing():
    """A picture has no script, style or link, so that any page can embed it."""
    kinds = {element.tag.removeprefix(SVG) for element in drawn(shipped("hospital").world).iter()}

    assert {"svg", "title", "rect", "circle", "path", "g", "text"} == kinds


@pytest.mark.parametrize(
    "world",
    [
        {},
        {"waypoints": {"a": [3, 3]}},
        {"bounds": [0, 0, 0, 0]},
        {"waypoints": {"a": [-1e7, 0], "b": [1e7, 1e7]}, "lanes": [["a", "b"]]},
        {"waypoints": {"a": [0, 0], "b": [0, 100]}, "lanes": [["a", "b"]]},
    ],
    ids=["empty", "a point", "bounds of no size", "huge", "a line"],
)
def test_odd_worlds(world):
    """Worlds without extent, or with a huge one, have a picture of reasonable size."""
    width, height = Drawing(World.model_validate(world)).size

    assert 1200 == width
    assert 100 < height < 1700
    assert "nan" not in Drawing(World.model_validate(world)).svg()


def test_lanes_in_colors_of_their_own():
    """Directions with their own color and width are drawn beside each other, with their notes."""
    svg = Drawing(TWO_ROOMS).svg(
        {("a", "b"): ("#123456", 5.0), ("b", "a"): ("#654321", 2.0)}, lane_notes={("a", "b"): "12 times"}
    )
    lane, there, back, _ = layer(ET.fromstring(svg), "lanes")

    assert ("#123456", "5", "a → b: 12 times") == (there.get("stroke"), there.get("stroke-width"), there[0].text)
    assert ("#654321", "2", []) == (back.get("stroke"), back.get("stroke-width"), list(back))
    assert 3 == len({way.get("d") for way in (lane, there, back)})


def test_a_huge_world_takes_little_time():
    """Ten thousand lanes with names take a few seconds of processor time at most."""
    side = 71
    grid = {
        "waypoints": {f"w{x}_{y}": [x * 5, y * 5] for x in range(side) for y in range(side)},
        "lanes": [
            [f"w{x}_{y}", f"w{x + dx}_{y + dy}"]
            for x in range(side)
            for y in range(side)
            for dx, dy in ((1, 0), (0, 1))
            if x + dx < side and y + dy < side
        ],
    }
    world = World.model_validate(grid)

    began = process_time()
    svg = Drawing(world).svg()

    assert process_time() - began < 5
    assert 9940 + len(["scale bar", "lane of the legend"]) == svg.count("<path ")


def test_what_is_far_larger_than_the_picture_takes_all_of_it():
    """A box far larger than the picture costs no more than one that fits."""
    labels = Labels((0.0, 0.0, 100.0, 100.0))
    labels.block((-1e9, -1e9, 1e9, 1e9))

    assert labels.place((50.0, 50.0), 2.0, 20.0, 10.0) is None


def test_what_is_beside_the_picture_takes_none_of_it():
    """A box outside the picture does not move a name."""
    labels = Labels((0.0, 0.0, 100.0, 100.0))
    before = labels.place((50.0, 50.0), 2.0, 20.0, 10.0)
    other = Labels((0.0, 0.0, 100.0, 100.0))
    other.block((200.0, 0.0, 300.0, 100.0))

    assert before == other.place((50.0, 50.0), 2.0, 20.0, 10.0)
