"""The map as cells, and the models of robots."""

from __future__ import annotations

import pytest

from hmrsim.simulation.simulator import Simulator
from hmrsim.world.model import World
from hmrsim_zenoh.ros2.publishing.views import grid_of, plan, urdf
from tests.cases import case
from tests.simulation import SMALL_WORLD


def rows(**world):
    """Return the cells of a world as text, the row of the least y first."""
    grid = grid_of(World.model_validate(world))
    text = "".join(".#"[cell // 100] for cell in grid.cells)
    return [text[i : i + grid.width] for i in range(0, len(text), grid.width)]


def test_walls_are_lines_and_solids_are_filled():
    for name, walls, expected in (
        ("wall", [[[0.01, 0.01], [0.19, 0.19]]], ["#...", ".#..", "..#.", "...#"]),
        (
            "solid",
            [{"solid": [[0.01, 0.01], [0.14, 0.01], [0.14, 0.14], [0.01, 0.14]]}],
            ["###.", "###.", "###.", "...."],
        ),
        ("beyond the bounds", [[[0.12, -5.0], [0.12, 5.0]]], ["..#.", "..#.", "..#.", "..#."]),
        ("corner", [[[0.01, 0.16], [0.16, 0.16], [0.16, 0.01]]], ["...#", "...#", "...#", "####"]),
    ):
        with case(name):
            assert expected == rows(bounds=[0, 0, 0.2, 0.2], walls=walls)


def test_a_map_without_bounds_has_a_margin():
    grid = grid_of(World.model_validate({"waypoints": {"a": [2, 3], "b": [4, 3]}}))

    assert (1.0, 2.0, 80, 40) == (grid.x, grid.y, grid.width, grid.height)


def test_the_cells_of_a_world_in_pixels_are_as_long_as_in_meters():
    grid = grid_of(World.model_validate({"units": "px", "bounds": [0, 0, 160, 80]}))

    assert (4.0, 40, 20) == (grid.resolution, grid.width, grid.height)


def test_the_cells_of_a_large_world_are_longer():
    grid = grid_of(World.model_validate({"bounds": [0, 0, 1000, 1000]}))

    assert 0.8 == pytest.approx(grid.resolution)
    assert 1250 * 1250 == len(grid.cells)


def test_a_model_is_as_wide_as_the_footprint():
    simulator = Simulator(
        World.model_validate(
            {"robot_types": {"t": {"base": {"radius": 0.4}}}, "robots": {"r": {"type": "t", "at": [0, 0]}}}
        )
    )

    assert '<cylinder radius="0.4" ' in urdf(simulator, "r")["data"]


def test_the_plan_of_a_standing_robot_is_its_pose():
    robot = Simulator(World.model_validate(SMALL_WORLD)).robots["eve"]

    (pose,) = plan(robot)["poses"]
    assert (9.0, 2.0) == (pose["pose"]["position"]["x"], pose["pose"]["position"]["y"])
