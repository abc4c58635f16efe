"""Checks of open paths against the simulator's lanes."""

from __future__ import annotations

import json

import pytest

from bt_controller.nodes.conditions.goals import IsPathValid, ValidatePath
from bt_controller.nodes.controls.sequences import ReactiveSequence
from hmrsim.interfaces.nav_msgs import Path
from hmrsim_zenoh.errors import RequestTimeout
from hmrsim_zenoh.wire.keys import Keys

A, B, C, D = (0.0, 0.0), (4.0, 0.0), (8.0, 0.0), (8.0, 4.0)
LANES = [(A, B), (B, A), (B, C), (C, B), (C, D)]


class World:
    """A client that returns the open lanes.

    Attributes:
        lanes: Those, in the direction in which they are driven.
        error: The error that the client raises instead.
    """

    def __init__(self):
        self.keys = Keys()
        self.lanes = LANES
        self.error = None
        self.kind = "MultiLineString"

    def get(self, key):
        assert "hmrsim/_world/route_graph" == key
        if self.error:
            raise self.error
        lines = [
            [[list(start), list(end)]] if self.kind == "MultiLineString" else [start, end] for start, end in self.lanes
        ]
        features = [{"geometry": {"type": "Point", "coordinates": [0, 0]}}]
        features += [{"geometry": {"type": self.kind, "coordinates": line}} for line in lines]
        return json.dumps({"features": features}).encode()

    def close(self, *lanes):
        self.lanes = [lane for lane in LANES if lane not in lanes]


@pytest.fixture
def world():
    """Return a world in which all lanes are open at first."""
    return World()


@pytest.fixture
def checked(node, tree, world, path):
    """Return the function that closes lanes after the tree is set up, and looks whether a path is valid."""

    def run(points, *closed, **ports):
        ticked = tree(node(ValidatePath, path=path(*points), collision_poses="{poses}", **ports), client=world)
        world.close(*closed)
        return ticked.tick()

    return run


ALL = {"stop_at_first_collision": "false"}
INSIDE = (5.0, 0.0)


@pytest.mark.parametrize(
    ("points", "closed", "ports", "invalid"),
    [
        ([A, B, C, D], [], {}, []),
        ([A, B, C, D], [(B, C), (C, B)], {}, [B]),
        ([A, B, C, D], [(B, C), (C, D)], {}, [B]),
        ([A, B, C, D], [(B, C), (C, D)], ALL, [B, C]),
        ([B, C], [(C, B)], {}, []),
        ([INSIDE, C], [(B, C)], {}, []),
        ([INSIDE, (6.0, 0.0), C, D], [(B, C)], {}, []),
        ([(8.0, 1.0), D], [(C, D)], {}, []),
        ([INSIDE, C, B, C], [(B, C)], {}, [B]),
        ([A, B, (6.0, 0.0)], [(B, C)], {}, [B]),
        ([(1.0, 0.0), C], [(B, C)], {}, [(1.0, 0.0)]),
        ([(0.0, 1.0), (8.0, 3.0)], [(B, C)], {}, []),
    ],
    ids=[
        "open lanes",
        "begins a closed lane",
        "the first of two such poses",
        "all such poses on request",
        "closed the other way",
        "leaves a closed lane, as the simulator allows",
        "leaves a closed lane by several poses",
        "leaves a closed lane to the north",
        "comes back to a lane that it has left",
        "a part of a closed lane",
        "a leg over several lanes",
        "no lanes: only walls count, which the planner has taken into account",
    ],
)
def test_a_path_is_valid_unless_it_begins_a_closed_lane(checked, board, points, closed, ports, invalid):
    assert ("F" if invalid else "S") == checked(points, *closed, **ports)
    assert invalid == [(pose.pose.position.x, pose.pose.position.y) for pose in board["/poses"]]


def test_a_lane_that_is_open_again_is_valid_again(node, tree, world, path):
    ticked = tree(node(ValidatePath, path=path(A, B, C)), client=world)
    world.close((B, C))
    assert "F" == ticked.tick()
    world.close()
    assert "S" == ticked.tick()


def test_a_lane_that_was_closed_at_first_is_known_once_it_has_been_open(node, tree, world, path):
    world.close((B, C))
    ticked = tree(node(ValidatePath, path=path(A, B, C)), client=world)
    assert "S" == ticked.tick()
    world.close()
    ticked.tick()
    world.close((B, C))
    assert "F" == ticked.tick()


def test_lanes_may_be_lines_too(checked, world):
    world.kind = "LineString"

    assert "F" == checked([A, B, C], (B, C))


@pytest.mark.parametrize("path", ["{path}", Path()])
def test_no_path_is_not_valid(node, tree, world, path):
    assert "F" == tree(node(ValidatePath, path=path), client=world).tick()


def test_a_path_of_one_pose_is_valid(checked):
    assert "S" == checked([A], (A, B))


def test_a_simulator_that_does_not_say_is_a_failure(node, tree, world, path):
    ticked = tree(node(ValidatePath, path=path(A, B)), client=world)
    world.error = RequestTimeout("no answer")

    assert "F" == ticked.tick()
    assert "no answer" == ticked.root.feedback_message


@pytest.mark.parametrize("kind", [IsPathValid, ValidatePath])
def test_it_has_to_be_looked_at_each_period(node, tree, told, world, path, kind):
    ticked = tree(node(ReactiveSequence, node(kind, path=path(A, B)), told("R")), client=world)
    ticked.tick()

    assert 1.0 == ticked.due()
