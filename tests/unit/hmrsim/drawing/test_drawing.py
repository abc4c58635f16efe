"""Pictures of worlds as SVG, with an overlay of traffic, and their colors."""

from __future__ import annotations

import itertools
from itertools import combinations
from math import dist
from xml.etree import ElementTree as ET

import pytest

from hmrsim.drawing import PALETTE, THEMES, Drawing, Overlay, Weak, type_looks
from hmrsim.drawing.labels import Labels
from hmrsim.world import World
from hmrsim.world.files import shipped_maps
from tests.calls import calls_of
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
        "robots": {"eve": {"at": "b", "yaw": 1.5707963267948966}, "wall_e": {"type": "drone", "at": [16, 8]}},
    }
)


def drawn(world, theme="light", **options):
    return ET.fromstring(Drawing(world, theme, **options).svg())


def layer(picture, name):
    return [part for group in picture.iter(f"{SVG}g") if group.get("class") == name for part in group]


def texts(picture):
    return [element.text for element in picture.iter(f"{SVG}text")]


def test_everything_is_drawn_once():
    numbers = {"walls": 2, "solids": 1, "lanes": 2, "waypoints": 3, "places": 1, "docks": 2, "doors": 1, "lifts": 2}
    numbers |= {"items": 1, "robots": 2}

    assert numbers == {name: len(layer(drawn(TWO_ROOMS), name)) for name in numbers}


@pytest.mark.parametrize("theme", THEMES)
@pytest.mark.parametrize("name", MAPS)
def test_shipped_worlds_are_well_formed_svg(name, theme):
    world = shipped(name).world
    picture = drawn(world, theme)

    assert len(world.robots) == len(layer(picture, "robots"))
    assert len(world.lanes) == len(layer(picture, "lanes"))


def test_drawing_is_deterministic():
    assert Drawing(TWO_ROOMS).svg() == Drawing(TWO_ROOMS.model_copy(deep=True)).svg()


@pytest.mark.parametrize(("units", "up"), [("m", True), ("px", False)])
def test_y_points_up_in_meters_and_down_in_pixels(units, up):
    low, _, high = layer(drawn(TWO_ROOMS.model_copy(update={"units": units})), "waypoints")

    assert up == (float(low.get("cy")) > float(high.get("cy")))


@pytest.mark.parametrize(("units", "ahead"), [("m", -1), ("px", 1)])
def test_robots_face_along_their_yaw(units, ahead):
    eve = layer(drawn(TWO_ROOMS.model_copy(update={"units": units})), "robots")[0]

    assert f"rotate({90 * ahead})" in eve.get("transform")


def test_points_are_placed_within_the_bounds():
    drawing = Drawing(TWO_ROOMS)
    floor = next(element for element in drawn(TWO_ROOMS).iter(f"{SVG}rect") if element.get("class") == "floor")
    x, y, width, height = (float(floor.get(key)) for key in ("x", "y", "width", "height"))

    assert (x + width / 2, y + height / 2) == pytest.approx(drawing.frame.at((10, 5)))
    assert width == pytest.approx(2 * height)


def test_the_first_robot_is_a_yellow_cart():
    shapes = PALETTE["bodies"]["types"]
    looks = {"carrier": ("#f5c400", shapes[0]), "drone": ("#4cbefc", shapes[1])}
    assert looks == type_looks(TWO_ROOMS)
    bodies = [
        [(part.get("fill"), part.get("d")) for part in robot.iter(f"{SVG}path")]
        for robot in layer(drawn(TWO_ROOMS, legend=False), "robots")
    ]
    assert [look in drawn_as for look, drawn_as in zip(looks.values(), bodies, strict=True)] == [True, True]


def test_only_a_flying_robot_has_rotors():
    eve, drone = layer(drawn(TWO_ROOMS), "robots")

    assert (0, 4) == (len(list(eve.iter(f"{SVG}circle"))), len(list(drone.iter(f"{SVG}circle"))))


def test_a_one_way_lane_has_an_arrow_and_a_tooltip():
    both, one_way = layer(drawn(TWO_ROOMS), "lanes")

    assert (1, 2) == (both.get("d").count("M"), one_way.get("d").count("M"))
    assert "b → c, ≤ 0.5 m/s, 2 at once" == one_way[0].text


def test_details_are_shown_on_request():
    assert "≤ 0.5 m/s, 2 at once" in texts(drawn(TWO_ROOMS, details=True))
    assert "≤ 0.5 m/s, 2 at once" not in texts(drawn(TWO_ROOMS))


def test_names_can_be_left_out():
    assert {"eve", "wall_e", "desk", "plug", "gate", "tower", "box"} <= set(texts(drawn(TWO_ROOMS)))
    assert [] == texts(drawn(TWO_ROOMS, names=False, legend=False))


def test_the_legend_explains_exactly_the_drawn_marks():
    world = World.model_validate({"waypoints": {"a": [0, 0], "b": [5, 0]}, "lanes": [["a", "b"]]})

    assert ["0.5 m", "world", "1 lane", "lane"] == [text for text in texts(drawn(world)) if text not in "ab"]


@pytest.mark.parametrize("name", MAPS)
def test_names_do_not_overlap(name):
    """The test assumes a wide font."""
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
    world = TWO_ROOMS.model_copy(update={"name": HOSTILE, "places": {HOSTILE: TWO_ROOMS.places["desk"]}})
    picture = drawn(world.model_copy(update={"items": {}}))
    shown = "<img src=x onerror=alert(1)> & \"'\ufffd\ufffd]]>"

    assert shown == picture.find(f"{SVG}title").text == layer(picture, "places")[0][0].text
    assert not list(picture.iter(f"{SVG}img"))


def test_a_picture_has_no_script_style_or_link():
    """Any page can then embed it."""
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
def test_worlds_without_extent_have_a_picture(world):
    width, height = Drawing(World.model_validate(world)).size

    assert 1200 == width
    assert 100 < height < 1700
    assert "nan" not in Drawing(World.model_validate(world)).svg()


def test_highlighted_directions_are_drawn_side_by_side():
    svg = Drawing(TWO_ROOMS).svg(
        {("a", "b"): ("#123456", 5.0), ("b", "a"): ("#654321", 2.0)}, lane_notes={("a", "b"): "12 times"}
    )
    lane, there, back, _ = layer(ET.fromstring(svg), "lanes")

    assert ("#123456", "5", "a → b: 12 times") == (there.get("stroke"), there.get("stroke-width"), there[0].text)
    assert ("#654321", "2", []) == (back.get("stroke"), back.get("stroke-width"), list(back))
    assert 3 == len({way.get("d") for way in (lane, there, back)})


def test_a_huge_world_is_drawn():
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

    svgs = []
    calls = calls_of(lambda: svgs.append(Drawing(world).svg()))

    assert calls < 5_000_000
    assert 9940 + len(["scale bar", "lane of the legend"]) == svgs[0].count("<path ")


def test_a_huge_box_costs_no_more_than_the_picture():
    labels = Labels((0.0, 0.0, 100.0, 100.0))
    labels.block((-1e9, -1e9, 1e9, 1e9))

    assert labels.place((50.0, 50.0), 2.0, 20.0, 10.0) is None


def test_a_box_outside_the_picture_moves_no_name():
    labels = Labels((0.0, 0.0, 100.0, 100.0))
    before = labels.place((50.0, 50.0), 2.0, 20.0, 10.0)
    other = Labels((0.0, 0.0, 100.0, 100.0))
    other.block((200.0, 0.0, 300.0, 100.0))

    assert before == other.place((50.0, 50.0), 2.0, 20.0, 10.0)


def test_a_line_leads_to_a_label_without_room_beside_its_mark():
    labels = Labels((0.0, 0.0, 100.0, 100.0))
    labels.block((0.0, 40.0, 48.0, 60.0))
    labels.block((52.0, 40.0, 100.0, 60.0))

    (x, y), line = labels.place((50.0, 50.0), 2.0, 20.0, 10.0)

    assert (50.0, line) == (x, (50.0, y + 5.0))
    assert y + 5.0 < 40.0


WORLD = World.model_validate(
    {
        "waypoints": {"a": [0, 0], "b": [9, 0], "c": [9, 9], "d": [30, 9]},
        "lanes": [["b", "a"], ["b", "c"]],
        "lifts": {"tower": {"stops": ["c", "d"]}},
    }
)
OVERLAY = Overlay(
    {("a", "b"): 0.5, ("b", "c"): 0.1, ("c", "d"): 0.5},
    (
        Weak(("a", "b"), "lane", 1.0, "the only way"),
        Weak(("b",), "waypoint", 0.5, "a knot"),
        Weak(("c", "d"), "lift", 1, "x"),
    ),
)


@pytest.mark.parametrize("theme", THEMES)
def test_more_traffic_is_wider_and_darker(theme):
    """The order of a lane's ends makes no difference."""
    overlay = Overlay(OVERLAY.shares, OVERLAY.weak, theme)
    picture = ET.fromstring(Drawing(WORLD, theme, overlay=overlay).svg())
    taken = [lane for lane in layer(picture, "lanes") if lane.get("stroke") in PALETTE["heat"][theme]]

    assert [PALETTE["heat"][theme][-1], PALETTE["heat"][theme][1]] == [lane.get("stroke") for lane in taken]
    assert float(taken[0].get("stroke-width")) > float(taken[1].get("stroke-width"))
    assert "50.0% of trips, either way" in taken[0][0].text


def test_bottlenecks_are_marked():
    picture = ET.fromstring(Drawing(WORLD, overlay=OVERLAY).svg())
    ride, lane = layer(picture, "only-lanes")

    assert (None, "the only way") == (lane.get("stroke-dasharray"), lane[0].text)
    assert ("2 6", "c - d, a ride: 50.0% of trips, either way") == (ride.get("stroke-dasharray"), ride[0].text)
    assert ["x", "x", "a knot"] == [ring[0].text for ring in layer(picture, "only-waypoints")]


def test_the_legend_explains_the_overlay():
    drawn = {text.text for text in ET.fromstring(Drawing(WORLD, overlay=OVERLAY).svg()).iter(f"{SVG}text")}
    plain = {text.text for text in ET.fromstring(Drawing(WORLD).svg()).iter(f"{SVG}text")}

    assert {"up to 50% of trips", "bottleneck lane", "bottleneck waypoint or lift"} == drawn - plain


def test_an_empty_overlay_draws_nothing():
    world = World.model_validate({"waypoints": {"a": [0, 0]}})

    assert Drawing(world).svg() == Drawing(world, overlay=Overlay({}, ())).svg()


SEEN = {
    "all colours": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    "no red": ((0.152286, 1.052583, -0.204868), (0.114503, 0.786281, 0.099216), (-0.003882, -0.048116, 1.051998)),
    "no green": ((0.367322, 0.860646, -0.227968), (0.280085, 0.672501, 0.047413), (-0.01182, 0.04294, 0.968881)),
    "no blue": ((1.255528, -0.076749, -0.178779), (-0.078411, 0.930809, 0.147602), (0.004733, 0.691367, 0.3039)),
}
"""Linear RGB as color-blind people see it, after Machado, Oliveira and Fernandes (2009) at full severity."""
_LMS = (
    (0.4122214708, 0.5363325363, 0.0514459929),
    (0.2119034982, 0.6806995451, 0.1073969566),
    (0.0883024619, 0.2817188376, 0.6299787005),
)
_OKLAB = (
    (0.2104542553, 0.793617785, -0.0040720468),
    (1.9779984951, -2.428592205, 0.4505937099),
    (0.0259040371, 0.7827717662, -0.808675766),
)
MIN_DISTANCE = 0.12
"""Distance in Oklab; 0.02 is just noticeable between adjacent colors, but robots are far from each other."""


def times(matrix, vector):
    return tuple(sum(a * b for a, b in zip(row, vector, strict=True)) for row in matrix)


def linear(colour):
    parts = (int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return tuple(part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts)


def oklab(rgb):
    """Return a linear color in a space where distances are perceptual."""
    return times(_OKLAB, [value ** (1 / 3) for value in times(_LMS, [min(1.0, max(0.0, part)) for part in rgb])])


def luminance(colour):
    return sum(a * b for a, b in zip((0.2126, 0.7152, 0.0722), linear(colour), strict=True))


@pytest.mark.parametrize("who", SEEN)
def test_types_of_robots_differ(who):
    seen = {colour: oklab(times(SEEN[who], linear(colour))) for colour in PALETTE["types"]}

    near = {pair: dist(seen[pair[0]], seen[pair[1]]) for pair in combinations(seen, 2)}
    assert {} == {pair: round(away, 3) for pair, away in near.items() if away < MIN_DISTANCE}


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_the_wedge_has_the_color_of_the_outline(theme):
    ink = luminance(PALETTE[theme]["robot_outline"])

    assert all((luminance(colour) + 0.05) / (ink + 0.05) > 2.3 for colour in PALETTE["types"])
