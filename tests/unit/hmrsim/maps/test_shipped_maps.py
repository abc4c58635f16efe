"""The worlds that are shipped with hmrsim."""

from __future__ import annotations

import pytest

from hmrsim.actions import registry
from hmrsim.navigation.graph import WaypointGraph
from hmrsim.protocol.commands import SendGoal
from hmrsim.simulation.simulator import Simulator
from hmrsim.world.files import folder, shipped_maps
from hmrsim.world.model import Traffic
from tests.shipped import shipped
from tests.simulation import Log

pytestmark = pytest.mark.uncovered  # whole runs, of lines that other tests cover

NAVIGATE = registry()["navigate_to_pose"]


@pytest.fixture(
    params=[
        "cafe",
        "hospital",
        "hospital_fleet",
        "hospital_logistics",
        "scenario1",
        "scenario2",
        "warehouse",
        "warehouse_orders",
    ],
    scope="module",
)
def name(request):
    return request.param


@pytest.fixture(scope="module")
def loaded(name):
    return shipped(name)


def places(world):
    """Return the points of all places and docks, or of waypoints if there are none."""
    points = [place.at for place in (*world.places.values(), *world.docks.values())]
    return points or [*world.waypoints.values()]


def go(x, y):
    return NAVIGATE.goal.model_validate({"pose": {"pose": {"position": {"x": x, "y": y}}}})


def test_the_folder_has_exactly_these_worlds():
    zoo = ["charger_queue", "corridor_swap", "crossing", "dead_end", "door", "lift", "token_swap"]

    assert [
        "cafe",
        "hospital",
        "hospital_fleet",
        "hospital_logistics",
        "scenario1",
        "scenario2",
        "warehouse",
        "warehouse_orders",
        *(f"zoo/{name}" for name in zoo),
    ] == list(shipped_maps())


def test_the_first_line_names_the_schema(loaded):
    first, _, _ = loaded.path.read_text(encoding="utf-8").partition("\n")

    assert first == "# yaml-language-server: $schema=../schemas/world.schema.json"
    assert (folder("maps") / "../schemas/world.schema.json").is_file()


def test_routes_connect_all_places(loaded):
    graph = WaypointGraph(loaded.world)
    points = [*places(loaded.world), *(loaded.world.point(robot.at) for robot in loaded.world.robots.values())]
    points = [*dict.fromkeys(points)]

    routes = [graph.plan(start, goal, 1.0) for start in points for goal in points]

    assert len(points) == sum(not route.legs for route in routes)


def test_every_robot_arrives_without_interference(loaded):
    log = Log(frozenset())
    robots = {name: robot.model_copy(update={"script": ()}) for name, robot in loaded.world.robots.items()}
    empty = {"robots": robots, "traffic": Traffic(policy="free"), "doors": {}, "faults": ()}
    simulator = Simulator(loaded.world.model_copy(update=empty), sinks=[log])
    points = places(loaded.world)
    for i, robot in enumerate(simulator.robots, start=1):
        simulator.submit(SendGoal(robot, NAVIGATE.name, go(*points[i % len(points)]), goal_id=f"{i:032x}"))
    simulator.run()

    ends = {robot: log.changes(f"{i:032x}")[-1][1] for i, robot in enumerate(simulator.robots, start=1)}
    assert dict.fromkeys(simulator.robots, "SUCCEEDED") == ends
