"""The worlds that hmrsim brings along."""

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
    """Return the bare name of a shipped world."""
    return request.param


@pytest.fixture(scope="module")
def loaded(name):
    """Return a shipped world."""
    return shipped(name)


def places(world):
    """Return where robots go: the points of all places and docks, or of waypoints where there are none."""
    points = [place.at for place in (*world.places.values(), *world.docks.values())]
    return points or [*world.waypoints.values()]


def go(x, y):
    """Return a goal for navigate_to_pose."""
    return NAVIGATE.goal.model_validate({"pose": {"pose": {"position": {"x": x, "y": y}}}})


def test_what_is_shipped():
    """The folder has these worlds and a zoo, and nothing else that would be taken for one."""
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


def test_files_are_completed_by_editors(loaded):
    """The first line names the schema."""
    first, _, _ = loaded.path.read_text(encoding="utf-8").partition("\n")

    assert first == "# yaml-language-server: $schema=../schemas/world.schema.json"
    assert (folder("maps") / "../schemas/world.schema.json").is_file()


def test_everything_is_reached_from_everywhere(loaded):
    """A route leads from each place, dock and start of a robot to each other."""
    graph = WaypointGraph(loaded.world)
    points = [*places(loaded.world), *(loaded.world.point(robot.at) for robot in loaded.world.robots.values())]
    points = [*dict.fromkeys(points)]

    routes = [graph.plan(start, goal, 1.0) for start in points for goal in points]

    assert len(points) == sum(not route.legs for route in routes)


def test_every_robot_drives(loaded):
    """All robots set out at once, and each arrives if no robot, door, fault or script interferes."""
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
