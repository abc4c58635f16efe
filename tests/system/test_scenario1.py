"""Driving, grabbing and dropping by commands in a terminal, on our world and on the imported map."""

from __future__ import annotations

import json
import queue

import pytest

from hmrsim_zenoh import Client, Commander, SessionOptions
from tests.paths import REFERENCES
from tests.patience import PATIENCE

DRAWING = REFERENCES / "drawio" / "place_with_walls.drawio"

OURS = [
    ("/wall_e/navigate_to_pose", "{pose: {pose: {position: {x: 512, y: 215, z: 1}}}}"),
    ("/wall_e/pickup", "{target_name: medicine}"),
    ("/wall_e/navigate_to_pose", "{pose: {pose: {position: {x: 100, y: 180, z: 1}}}}"),
    ("/wall_e/place", "{attached_object_name: medicine}"),
]
ORIGINALS = [
    ("navigate_to_pose/wall_e", "{pose: { pose: { position: {x: 512, y: 215, z: 1} } } }"),
    ("wall_e/grab", "{ target_name: 'medicine' }"),
    ("navigate_to_pose/wall_e", "{pose: { pose: { position: {x: 100, y: 180, z: 1} } } }"),
    ("wall_e/drop", "{attached_object_name: 'medicine'}"),
]
TYPES = {
    "navigate_to_pose": "nav2_msgs/action/NavigateToPose",
    "grab": "moveit_msgs/action/Pickup",
    "drop": "moveit_msgs/action/Place",
}


def follow(command, endpoint, orders, *, typed=False):
    """Send each order, and return the last feedback distance of each that drives."""
    distances = []
    for name, goal in orders:
        kind = [next(ros for word, ros in TYPES.items() if word in name)] if typed else []
        code, out, err = command(
            "hmrsim", "action", "send-goal", name, *kind, goal, "--feedback", "--json", endpoint=endpoint
        )
        assert 0 == code, (out, err)
        lines = [json.loads(line) for line in out.splitlines()]
        assert "SUCCEEDED" in out.splitlines()[-1]
        feedback = [line["feedback"] for line in lines if "feedback" in line]
        if "navigate" in name:
            distances.append([item["distance_remaining"] for item in feedback])
    return distances


def placed(command, endpoint):
    _, out, _ = command("hmrsim", "topic", "echo", "/wall_e/odom", "--once", "--json", endpoint=endpoint)
    position = json.loads(out)["pose"]["pose"]["position"]
    return position["x"], position["y"]


def fetch(client):
    """Do in Python what the four commands do."""
    wall_e = Commander(client, "wall_e")
    wall_e.go_to_pose(512, 215)
    wall_e.pickup("medicine")
    wall_e.go_to_pose(100, 180)
    wall_e.place("medicine")


@pytest.mark.parametrize("orders", [OURS, ORIGINALS], ids=["our names", "the original's names"])
def test_the_four_commands_succeed_on_our_world(serve, command, orders):
    _, endpoint = serve("scenario1", "--real-time-factor", "10")

    for distances in follow(command, endpoint, orders):
        assert 0.0 == distances[-1]
        assert sorted(distances, reverse=True) == distances
    assert (100.0, 180.0) == placed(command, endpoint)


@pytest.mark.skipif(not DRAWING.exists(), reason="the original's drawing is not committed to the project")
def test_the_four_commands_succeed_on_the_imported_map(serve, command, tmp_path):
    world = tmp_path / "original.yaml"
    (tmp_path / DRAWING.name).write_bytes(DRAWING.read_bytes())
    world.write_text(
        f"units: px\ninclude: [{DRAWING.name}]\n"
        "remap:\n"
        "  navigate_to_pose/wall_e: wall_e/navigate_to_pose\n"
        "  wall_e/grab: wall_e/pickup\n"
        "  wall_e/drop: wall_e/place\n"
    )
    _, endpoint = serve(world, "--real-time-factor", "10")

    for distances in follow(command, endpoint, ORIGINALS, typed=True):
        assert 0.0 == distances[-1]
    assert (100.0, 180.0) == placed(command, endpoint)


def test_the_placed_medicine_is_at_the_robots_center(serve):
    _, endpoint = serve("scenario1", "--real-time-factor", "10")
    told = queue.SimpleQueue()
    with Client(SessionOptions(connect=(endpoint,))) as client:
        client.subscribe(client.keys.world("events"), lambda _key, payload: told.put(json.loads(payload)))
        # Goals that take no time, until the simulator is known to have matched the subscriber.
        while told.empty():
            Commander(client, "wall_e").wait(0)
        fetch(client)
        dropped = next(event for event in iter(lambda: told.get(timeout=PATIENCE), None) if event["kind"] == "placed")

    assert ("wall_e", "medicine", [100.0, 180.0]) == (dropped["robot"], dropped["item"], dropped["at"])


def test_the_simulator_logs_each_goal_and_each_end(serve):
    simulator, endpoint = serve("scenario1", "--real-time-factor", "10")
    with Client(SessionOptions(connect=(endpoint,))) as client:
        fetch(client)
    code, _, log = simulator.end(15)

    assert 0 == code
    for words in (
        "navigate_to_pose accepted: (512, 215)",
        "pickup accepted: medicine",
        "navigate_to_pose SUCCEEDED",
        "place SUCCEEDED",
    ):
        assert words in log
