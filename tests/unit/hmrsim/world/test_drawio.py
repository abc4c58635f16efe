"""Drawings: our own, and the original's if available."""

from __future__ import annotations

from pathlib import Path

import pytest

from hmrsim.navigation.graph import WaypointGraph
from hmrsim.world import ReadOptions
from hmrsim.world_checks import load_world
from tests.paths import REFERENCES

HERE = Path(__file__).parent
REFERENCE = REFERENCES / "drawio"


def spans(world):
    return [
        tuple(round(edge(point[i] for point in wall.solid), 3) for edge in (min, max) for i in (0, 1))
        for wall in world.walls
    ]


def read(name, **options):
    loaded = load_world(HERE / "data" / f"{name}.drawio", options=ReadOptions(**options))
    return loaded.world, [str(warning).rpartition(".drawio:")[2] for warning in loaded.warnings]


@pytest.fixture(scope="module")
def ward():
    """A drawing with every feature that the original's maps use, as the desktop editor saves it."""
    return read("ward")[0]


def test_the_page_is_the_world(ward):
    assert (ward.name, ward.units, ward.bounds) == ("Ward", "px", (0, 0, 600, 400))


def test_shapes_are_solids_but_text_is_not(ward):
    assert spans(ward) == [
        (0, 10, 600, 20),
        (295, 100, 305, 300),
        (450, 250, 550, 260),
        (540, 250, 550, 350),
        (450, 340, 550, 350),
        (40, 40, 100, 60),
        (150, 300, 170, 320),
    ]


def test_things_are_at_their_center(ward):
    assert ward.items["syrup"].at == (68.5, 49.0)
    assert {name: place.at for name, place in ward.places.items()} == {"bed": (100, 350), "POI_1": (400, 80)}


def test_robots_have_claw_script_and_name(ward):
    eve, other = ward.robots["eve"], ward.robots["robot_1"]

    assert (eve.at, eve.components) == ((500, 80), {"claw": {"reach": 60, "max_weight": 2}})
    assert (other.at, other.components, other.script) == ((100, 100), {}, ("Go bed", "Go 450 80"))


def test_roads_are_waypoints_and_lanes(ward):
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


def test_old_map_has_ways_batteries_and_speeds():
    world, warnings = read("old_map")
    walter, other = world.robots.values()

    assert warnings == []
    assert list(world.robots) == ["walter", "robot_1"]
    assert walter.base.speed == 300
    assert walter.script == ("Follow 130 200 200.5 120 400 120 400 200", "Go desk", "Wait 2", "Go 500 350")
    assert walter.components == {
        "battery": {"capacity": 5000, "initial_charge": 5000, "drain": {"default": 1, "still": 0.5, "moving": 2}}
    }
    assert other.script == ("Follow 500 60 560 60",)
    assert other.components == {"battery": {"capacity": 3600}, "claw": {"reach": 80, "max_weight": 1}}


@pytest.mark.parametrize(
    ("page", "name", "places", "items", "walls"),
    [
        (None, "Ground floor", {"lift"}, {"medicine"}, 4),
        ("2", "Upper floor", {"lift", "bed"}, set(), 7),
        ("Upper floor", "Upper floor", {"lift", "bed"}, set(), 7),
    ],
)
def test_compressed_drawing_has_two_floors(page, name, places, items, walls):
    world, warnings = read("two_floors", page=page, rename={"robot_1": "wall_e"})

    assert warnings == []
    assert (world.name, set(world.places), set(world.items), len(world.walls)) == (name, places, items, walls)
    assert {name: robot.at for name, robot in world.robots.items()} == {"wall_e": (100, 100)}
    assert list(world.waypoints.values()) == [(100, 100), (100, 290), (100, 300)]


def test_floor_plan_has_groups_in_groups_and_a_hidden_layer():
    world, warnings = read("floor_plan")

    assert warnings == ["8: cell 'notes' (Notes): is a hidden layer; what is on it is read all the same"]
    assert spans(world)[-2:] == [(20, 340, 220, 350), (125, 365, 155, 385)]
    assert world.places["bed"].at == (140, 375)
    assert world.items["syrup"].at == (326, 376)
    assert list(world.waypoints.values()) == [(30, 380), (80, 380)]


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
    world = load_world(REFERENCE / f"{name}.drawio").world
    (robot,) = world.robots.values()
    graph = WaypointGraph(world)

    assert robot.at == start
    assert [graph.plan(robot.at, goal, 300.0).length > 0.0 for goal in goals] == [True] * len(goals)


@pytest.mark.skipif(not REFERENCE.is_dir(), reason="the original's maps are not here; they are under the GPL")
@pytest.mark.parametrize(
    ("name", "robot", "components", "orders"),
    [
        ("hospital", "wall_e", {"claw": {"reach": 80, "max_weight": 1}}, ()),
        ("place_with_walls", "wall_e", {"claw": {"reach": 80, "max_weight": 1}}, ()),
        ("poi_test", "robot_1", {}, ("Go 1", "Go 2", "Go 3", "Go 7", "Go 9", "Go 450 330")),
    ],
)
def test_original_map_has_its_robot(name, robot, components, orders):
    loaded = load_world(REFERENCE / f"{name}.drawio")

    assert [str(warning) for warning in loaded.warnings if "left out" in str(warning)] == []
    assert list(loaded.world.robots) == [robot]
    assert loaded.world.robots[robot].components == components
    assert loaded.world.robots[robot].script == orders
