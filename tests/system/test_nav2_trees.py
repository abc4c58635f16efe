"""Nav2's available trees, and three of ours with the same nodes, load and drive."""

from __future__ import annotations

from pathlib import Path

import pytest
from py_trees.common import Status

from bt_controller.loading.trees import load
from bt_controller.running.clocks import STOP, Mailbox, clock_for
from bt_controller.running.mission import Mission
from bt_controller.running.runner import Runner
from hmrsim_zenoh.client.client import Client
from tests.paths import nav2_files
from tests.served_world import served_world
from tests.shipped import shipped

OURS = Path(__file__).parent / "trees"

THEIRS = [file for file in nav2_files(".xml") if "<BehaviorTree " in file.read_text()]

ENDLESS = {"follow_point.xml"}
"""Trees that keep following their goal."""

HOSPITAL = {
    "goal": "ward_a_window",
    "goals": "hall_lab|ward_a_window",
    "picking_location": "lab_floor",
    "placing_location": "nurse_station",
    "dock_id": "charger_7",
    "dock_type": "charger",
}
CROSSING = {
    "goal": "19;-0.5",
    "goals": "near_west|19;-0.5",
    "picking_location": "near_north",
    "placing_location": "near_south",
    "dock_id": "charger",
    "dock_type": "charger",
}


def crossing():
    """Return the crossing of the zoo with one robot, beside its lane, and a dock."""
    plain = shipped("zoo/crossing").world.model_dump(mode="json", by_alias=True, exclude_unset=True)
    robot = {"at": [-18, 0.5], "base": {"radius": 0.4, "turning_rate": 1.5}, "components": {"battery": {}}}
    docks = {"charger": {"at": [2, 2], "type": "charger"}}
    return plain | {"docks": docks, "robots": {"eastbound": robot}}


WORLDS = {
    "hospital": (lambda: shipped("hospital").world, "auto", HOSPITAL),
    "crossing": (crossing, "eastbound", CROSSING),
}


def hospital():
    """Return the hospital, the robot and its destination."""
    make, robot, values = WORLDS["hospital"]
    return make(), robot, values


def run(tree, world, robot, values, *, until=300.0):
    """Run a tree in lockstep with these values; return its status, the time, and its blackboard."""
    text = tree.read_text()
    plan = load(str(tree), values={key: value for key, value in values.items() if f"{{{key}}}" in text})
    with served_world(world, clock="lockstep") as options, Client(options, name="trees") as client:
        mission, mailbox = Mission(robot, plan), Mailbox()
        clock = clock_for(client, mailbox, feedback=mission.wants_feedback, grace=0.1)

        def stop_in_time(_mission, now):
            if now is not None and now > until:
                mailbox.put(STOP)

        outcome = Runner(client, [mission], clock, mailbox, show=stop_in_time, grace=5.0).run()
        return outcome.statuses[robot], clock.now, dict(mission._board.storage)


@pytest.mark.parametrize("world", WORLDS)
@pytest.mark.parametrize("tree", THEIRS, ids=lambda file: file.stem)
def test_nav2s_trees_drive_to_success(tree, world):
    make, robot, values = WORLDS[world]
    status, _, _ = run(tree, make(), robot, values)

    assert (Status.RUNNING if tree.name in ENDLESS else Status.SUCCESS) is status


@pytest.mark.parametrize("world", WORLDS)
def test_a_route_is_planned_smoothed_and_driven(world):
    make, robot, values = WORLDS[world]
    status, _, board = run(OURS / "route.xml", make(), robot, values)

    assert Status.SUCCESS is status
    assert len(board["/route"].nodes) + 1 == len(board["/stops"])
    assert 0 == board["/route_error"]


def test_a_tree_waits_for_a_route_that_is_closed_for_a_while():
    """Two recoveries of five seconds pass, and the lane opens at 8 s."""
    fault = {"type": "lane_closed", "lane": ["near_west", "centre"], "at": 0, "until": 8}
    world = crossing() | {"faults": [fault, {**fault, "lane": ["near_west", "near_north"]}]}
    status, now, _ = run(OURS / "route.xml", world, "eastbound", CROSSING)

    assert Status.SUCCESS is status
    assert now > 10.0


def test_the_tree_tracks_the_waypoints_of_its_robot():
    status, _, board = run(OURS / "track.xml", *hospital())

    assert (Status.SUCCESS, "yes", 0) == (status, board["/at_ward_a"], board["/route_error"])


@pytest.mark.parametrize(("dx", "status"), [(0.1, Status.SUCCESS), (0.3, Status.FAILURE)])
def test_a_robot_that_believes_itself_off_its_path_is_stopped(dx, status):
    """The limit is 0.2 m: 0.1 m are accepted, and 0.3 m are not."""
    world, robot, values = hospital()
    fault = {"type": "localisation_jump", "robot": robot, "dx": dx, "at": 12}
    plain = world.model_dump(mode="json", by_alias=True, exclude_unset=True)

    assert status is run(OURS / "bounds.xml", plain | {"faults": [fault]}, robot, values)[0]
