"""Serving running trees to Groot2."""

from __future__ import annotations

import socket
import struct
from xml.etree import ElementTree as ET

import msgpack
import pytest
import zmq
from py_trees.common import Status

from bt_controller.running.snapshot import Node, Snapshot
from bt_controller.watching.groot2 import Groot2Publishers, tree_xml
from hmrsim_zenoh.errors import BadOptions

PATIENCE_MS = 60_000
SYMBOLS = {"Selector": "{o}", "SubTree": "-^-", "Inverter": "-^-"}


def node(depth, kind, name, status=Status.INVALID):
    return Node(depth, SYMBOLS.get(kind, "-->"), kind, name, status, "")


TREE = (
    node(0, "Selector", "serve", Status.RUNNING),
    node(1, "SubTree", "fetch", Status.RUNNING),
    node(2, "Pickup", "pick up", Status.RUNNING),
    node(1, "Inverter", "not"),
    node(2, "SubTree", "fetch"),
    node(3, "Pickup", "pick up again"),
)


class FakeMission:
    """A tree that tests tick."""

    robot = "eve"

    def __init__(self):
        self.nodes = TREE
        self.entries = {"goal": "ward_a"}

    def snapshot(self, sim_time, *, blackboard=False):
        return Snapshot(self.robot, sim_time, 1, self.nodes, blackboard=self.entries if blackboard else None)


@pytest.fixture
def port():
    with socket.create_server(("127.0.0.1", 0)) as probe:
        return probe.getsockname()[1]


@pytest.fixture
def mission():
    """Return the mission that is served."""
    return FakeMission()


@pytest.fixture
def served(mission, port):
    """Return the servers of that mission."""
    with Groot2Publishers([mission], port) as publishers:
        yield publishers


@pytest.fixture
def client(served):
    """Return a socket that is connected to the server."""
    with zmq.Context() as context, context.socket(zmq.REQ) as connected:
        connected.setsockopt(zmq.LINGER, 0)
        connected.setsockopt(zmq.RCVTIMEO, PATIENCE_MS)
        connected.connect(f"tcp://127.0.0.1:{served.ports['eve']}")
        yield connected


@pytest.fixture
def ask(client):
    """Return the function that sends a request of a type, and returns the frames of the reply."""

    def request(kind, *arguments):
        client.send_multipart([struct.pack("<BBI", 2, ord(kind), 7), *arguments])
        return client.recv_multipart()

    return request


def test_subtrees_are_trees_behind_the_one_that_has_them():
    root = ET.fromstring(tree_xml(TREE))
    trees = [
        (tree.get("ID"), [(each.tag, each.get("name"), each.get("_uid")) for each in tree.iter() if each is not tree])
        for tree in root.iter("BehaviorTree")
    ]

    assert "serve" == root.get("main_tree_to_execute")
    assert trees == [
        (
            "serve",
            [
                ("Fallback", "serve", "1"),
                ("SubTree", "fetch", "2"),
                ("Inverter", "not", "4"),
                ("SubTree", "fetch", "5"),
            ],
        ),
        ("fetch", [("Pickup", "pick up", "3")]),
        ("fetch", [("Pickup", "pick up again", "6")]),
    ]
    assert {("Action", "Pickup"), ("Control", "Fallback"), ("Decorator", "Inverter")} == {
        (model.tag, model.get("ID")) for model in root.find("TreeNodesModel")
    }


def test_replies_repeat_the_request_and_name_the_tree(ask):
    """A client tells by the name whether the tree is still the same."""
    headers = [ask(kind)[0] for kind in "TS"]

    assert [(2, ord(kind), 7) for kind in "TS"] == [struct.unpack("<BBI", header[:6]) for header in headers]
    assert headers[0][6:] == headers[1][6:]
    assert 16 == len(headers[0][6:])


def test_statuses(ask):
    _, content = ask("S")

    assert [*struct.iter_unpack("<HB", content)] == [(1, 1), (2, 1), (3, 1), (4, 0), (5, 0), (6, 0)]


def test_blackboard(ask):
    _, content = ask("B", b"ROOT;fetch")

    assert {"ROOT": {"goal": "ward_a"}, "fetch": {"goal": "ward_a"}} == msgpack.unpackb(content)


def test_transitions_are_recorded_on_request(ask, served, mission):
    ask("r", b"start")
    mission.nodes = (TREE[0]._replace(status=Status.SUCCESS), *TREE[1:])
    served.ticked(mission, 1.0)
    _, first = ask("t")
    _, second = ask("t")
    ask("r", b"stop")
    mission.nodes = TREE
    served.ticked(mission, 2.0)
    _, third = ask("t")

    assert [(1, 2)] == [transition[1:] for transition in struct.iter_unpack("<6sHB", first)]
    assert (b"", b"") == (second, third)


@pytest.mark.parametrize(
    ("frames", "error"),
    [
        ((b"x",), b"wrong request header"),
        ((struct.pack("<BBI", 2, ord("?"), 1),), b"Request not recognized"),
        ((struct.pack("<BBI", 2, ord("I"), 1), b"{}"), b"hmrsim supports no breakpoints"),
    ],
)
def test_requests_that_are_not_supported_are_errors(client, frames, error):
    client.send_multipart(frames)
    answer = client.recv_multipart()
    client.send(struct.pack("<BBI", 2, ord("S"), 1))

    assert [b"error", error] == answer
    assert 2 == len(client.recv_multipart())


def test_a_control_with_one_child_is_no_decorator():
    root = ET.fromstring(tree_xml((node(0, "Selector", "serve"), node(1, "Pickup", "pick up"))))

    assert root.find("TreeNodesModel/Control[@ID='Fallback']") is not None


def test_another_tree_has_another_id(port):
    ids = []
    for nodes in (TREE, TREE[:3], TREE):
        mission = FakeMission()
        mission.nodes = nodes
        with Groot2Publishers([mission], port), zmq.Context() as context, context.socket(zmq.REQ) as client:
            client.setsockopt(zmq.RCVTIMEO, PATIENCE_MS)
            client.connect(f"tcp://127.0.0.1:{port}")
            client.send(struct.pack("<BBI", 2, ord("S"), 1))
            ids.append(client.recv_multipart()[0][6:])

    assert ids[0] == ids[2] != ids[1]


def test_a_blackboard_that_messagepack_can_not_hold_is_an_error(ask, mission):
    mission.entries = {"goal": 2**70}

    assert b"error" == ask("B", b"ROOT")[0]
    assert 2 == len(ask("S"))


def test_ports_that_do_not_exist(mission):
    for port, trees, error in (
        (70_000, 1, "70000 is not a port"),
        (-1, 1, "-1 is not a port"),
        (65_535, 2, "the trees need the ports 65535 to 65537"),
    ):
        with pytest.raises(BadOptions, match=f"--groot2: {error}; ports are numbers from 1 to 65535"):
            Groot2Publishers([mission] * trees, port)


def test_a_port_that_is_taken(mission):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(BadOptions, match=f"port {port} can't be served"), Groot2Publishers([mission], port):
            pass
