"""Buildings of Open-RMF's traffic editor."""

from __future__ import annotations

from pathlib import Path

import pytest

from hmrsim.errors import WorldError
from hmrsim.navigation.graph import WaypointGraph
from hmrsim.world import ReadOptions
from hmrsim.world_checks import load_world
from tests.paths import REFERENCES

HERE = Path(__file__).parent
REFERENCE = REFERENCES / "rmf"
CLINIC = HERE / "data" / "clinic.building.yaml"

ONE_LANE = """\
name: hall
levels:
  L1:
    {more}
    lanes: [[0, 1, {{bidirectional: [4, true]}}]]
    vertices: [[0, 0, 0, a], [10, 10, 0, b]]
"""


@pytest.fixture(scope="module")
def clinic():
    """Two levels and a lift; one level is drawn to another scale and rotated."""
    return load_world(CLINIC).world


@pytest.fixture
def hall(load):
    """Loads a building of one lane with additions to its level or before it."""
    return lambda more="elevation: 0", before="": load(before + ONE_LANE.format(more=more), "hall.building.yaml")


def test_levels_become_meters_side_by_side_with_y_up(clinic):
    """Names that several levels have get the level as a prefix."""
    assert ["L1/lobby", "L1/v5", "charger_1", "L1/v7", "L2/v0", "ward", "L2/lobby"] == [*clinic.waypoints]
    assert [(2.0, -5.0), (8.0, -5.0)] == [clinic.waypoints[name] for name in ("L1/lobby", "charger_1")]
    assert [(18.0, -2.0), (15.0, -2.0)] == [clinic.waypoints[name] for name in ("L2/v0", "ward")]


def test_lanes_have_directions_and_limits(clinic):
    assert [
        ("L1/lobby", "L1/v5", False, None),
        ("L1/v5", "charger_1", False, 0.5),
        ("L1/v5", "L1/v7", True, None),
        ("L2/v0", "ward", False, None),
        ("L2/lobby", "L2/v0", True, None),
    ] == [(lane.from_, lane.to, lane.one_way, lane.speed_limit) for lane in clinic.lanes]


def test_walls_places_docks_doors_lifts_and_robots_are_read(clinic):
    """A named vertex that no lane touches is a place, and a robot faces along its first lane."""
    door, robot = clinic.doors["main_door"], clinic.robots["tiny_1"]
    docks = {name: (dock.at, dock.type) for name, dock in clinic.docks.items()}

    assert (((0, 0), (10, 0)), ((10, 0), (10, -10))) == clinic.walls
    assert {"atm": (9.0, -9.0)} == {name: place.at for name, place in clinic.places.items()}
    assert {"charger_1": ((8.0, -5.0), "charger"), "platform": ((5.0, -2.0), "dock")} == docks
    assert (((6.0, -4.5), (6.0, -5.5)), "hinged") == (door.at, door.type)
    assert {"Lift1": ("L1/v7", "L2/v0")} == {name: lift.stops for name, lift in clinic.lifts.items()}
    assert ("charger_1", "carrier", 3.141592653589793) == (robot.at, robot.type, robot.yaw)


def test_ignored_data_is_reported_once():
    warnings = [(warning.line, warning.message) for warning in load_world(CLINIC).warnings if warning.line]

    assert [
        (10, "floors: 1 left out"),
        (17, "orientation: 1 left out"),
        (19, "ways that were there before: 2 left out"),
        (19, "mutex: 1 left out"),
        (19, "graphs of lanes: 2 made one"),
        (22, "models: 1 left out"),
        (29, "is_holding_point: 1 left out"),
        (31, "robot 'tiny-1' is called 'tiny_1'; names are of letters, digits and _"),
        (31, "types of robots: 1 made carriers"),
    ] == warnings


def test_a_single_level_keeps_its_position():
    world = load_world(CLINIC, options=ReadOptions(page="L2")).world

    assert {"v0": (5.0, -2.0), "ward": (2.0, -2.0), "lobby": (8.0, -2.0)} == world.waypoints


def test_an_unknown_level_lists_the_levels():
    with pytest.raises(WorldError, match=r"has no level 'L3'; there are 1 \(L1\), 2 \(L2\)$"):
        load_world(CLINIC, options=ReadOptions(page="L3"))


def test_a_robot_is_renamed():
    world = load_world(CLINIC, options=ReadOptions(rename={"tiny_1": "eve"})).world

    assert ["eve"] == [*world.robots]


def test_the_scale_is_the_mean_of_the_measurements(hall):
    length = 14.142135623730951
    more = f"measurements: [[0, 1, {{distance: [3, {length}]}}], [1, 0, {{distance: [3, {2 * length}]}}]]"

    assert (15.0, -15.0) == hall(more).world.waypoints["b"]


def test_without_measurements_a_pixel_is_a_meter(hall):
    loaded = hall()

    assert (10.0, -10.0) == loaded.world.waypoints["b"]
    assert "levels.L1: has no measurements, so that a pixel of its drawing counts as a meter" in str(loaded.warnings[0])


def test_y_points_up_in_a_building_in_meters(hall):
    assert (10.0, 10.0) == hall(before="coordinate_system: cartesian_meters\n").world.waypoints["b"]


def test_degrees_become_meters(load):
    text = ONE_LANE.format(more="elevation: 0").replace("[10, 10, 0, b]", "[0.001, 0.001, 0, b]")
    waypoints = load(f"coordinate_system: wgs84\n{text}", "campus.building.yaml").world.waypoints

    assert pytest.approx((-55.6597, -55.2871), abs=1e-3) == waypoints["a"]
    assert pytest.approx((55.6597, 55.2871), abs=1e-3) == waypoints["b"]


def test_degrees_all_over_the_world_are_rejected(errors_of):
    """Such points are hardly degrees."""
    text = "coordinate_system: wgs84\n" + ONE_LANE.format(more="elevation: 0")

    assert ["3: levels: is not around one place; expected longitudes and latitudes"] == errors_of(
        text, "x.building.yaml"
    )


def test_duplicate_names_get_their_level_and_number(load):
    text = ONE_LANE.format(more="elevation: 0").replace("0, b]", "0, a], [5, 5, 0, a], [6, 6, 0, a]")
    world = load(text, "x.building.yaml").world

    assert (["a", "L1/a"], ["v2", "v3"]) == ([*world.waypoints], [*world.places])


def test_a_lift_without_waypoints_is_left_out(hall):
    lift = "lifts: {L: {x: 90, y: 0, width: 2, depth: 2, yaw: 0, level_doors: {L1: [d]}}}\n"

    assert {} == hall(before=lift).world.lifts


def test_all_errors_are_reported_with_their_lines(errors_of):
    text = """\
        name: bad
        coordinate_system: mercator
        reference_level_name: L9
        levels:
          L1:
            elevation: high
            lanes:
              - [0, 7, {}]
              - [0, 1, {bidirectional: true}]
              - [0]
              - [0, 1, {speed_limit: [3, fast]}]
            vertices:
              - [0, 0, 0, a]
              - [1, 0, 0, b]
              - [x, 0]
              - {}
            walls: 5
          L2:
        lifts:
          up: {x: 1}
          down: {x: 1, y: 1, reference_floor_name: L5}
        """

    assert [
        "2: coordinate_system: expected reference_image, cartesian_meters or wgs84, got 'mercator'",
        "3: reference_level_name: no level 'L9'; there are L1, L2",
        "6: levels.L1.elevation: expected a number, got 'high'",
        "8: levels.L1.lanes.0.1: no vertex 7; there are 4, from 0 on",
        "9: levels.L1.lanes.1.2.bidirectional: expected [type, value], got true",
        "10: levels.L1.lanes.2: expected [from, to, parameters], got [0]",
        "11: levels.L1.lanes.3.2.speed_limit.1: expected a number, got 'fast'",
        "15: levels.L1.vertices.2.0: expected a number, got 'x'",
        "16: levels.L1.vertices.3: expected a list, got a mapping",
        "17: levels.L1.walls: expected a list, got 5",
        "18: levels.L2: expected a mapping, got nothing",
        "20: lifts.up.y: is missing",
        "21: lifts.down.reference_floor_name: no level 'L5'; there are L1, L2",
    ] == errors_of(text, "bad.building.yaml")


def test_a_building_without_levels_is_reported(errors_of):
    assert ["1: has no levels"] == errors_of("levels: {}\n", "empty.building.yaml")


@pytest.mark.skipif(not REFERENCE.is_dir(), reason="Open-RMF's building is not here")
def test_open_rmf_s_sample_building_loads():
    loaded = load_world(REFERENCE / "office.building.yaml")
    world = loaded.world
    route = WaypointGraph(world).plan(world.point("tinyRobot1_charger"), world.point("coe"), 1.0)

    assert (29, 30, 33, 3, 2) == tuple(
        len(things) for things in (world.waypoints, world.lanes, world.walls, world.doors, world.robots)
    )
    assert pytest.approx(6.64, abs=0.01) == route.length
    assert {
        "floors: 4 left out",
        "models: 79 left out",
        "types of robots: 2 made carriers",
        "is_holding_point: 6 left out",
        "is_parking_spot: 3 left out",
        "pickup_dispenser: 1 left out",
        "dropoff_ingestor: 2 left out",
        "no lane leads through it",
    } == {warning.message for warning in loaded.warnings}
