"""Contracts of all nodes of XML trees, built in or not: every test runs over the registry."""

from __future__ import annotations

import json
from itertools import product

import pytest
from py_trees.behaviour import Behaviour
from py_trees.blackboard import Blackboard
from py_trees.common import Status
from py_trees.composites import Composite
from py_trees.decorators import Decorator

from bt_controller.core.blackboards import Board
from bt_controller.core.robots import TOPICS, Directory, Topics
from bt_controller.core.sim_time import simulated_time
from bt_controller.nodes import UNSUPPORTED, Family, actions, conditions, controls, decorators, registry
from bt_controller.running.schedule import due
from bt_controller.scripting.parser import parse
from hmrsim.plugins import discover
from hmrsim_zenoh.client.places import pose_at
from tests.cases import case
from tests.unit.bt_controller.conftest import FakeClient

VALUES = {
    "string": "text",
    "double": "0.5",
    "int": "1",
    "unsigned int": "1",
    "int[]": "1;2",
    "bool": "true",
    "any": "1",
    "NodeStatus": "SUCCESS",
    "geometry_msgs/PoseStamped": "1;2",
    "geometry_msgs/PoseStamped[]": "1;2|3;4",
    "nav_msgs/Path": "1;2|3;4",
}
"""What a file may say of each kind."""

ENDS = [Status.SUCCESS, Status.FAILURE, Status.RUNNING, Status.INVALID]


class Robot(FakeClient):
    """A client of one robot that can do anything, with a full battery, in a world without lanes."""

    now = 0.0

    def info(self):
        known = {getattr(node, "ACTION", None) for node in registry().values()} - {None}
        return {"robots": [{"name": "wall_e", "actions": sorted({*known, "navigate_to_pose"})}], "aliases": {}}

    def get(self, key, **_):
        """Return what is published there; the result of a service is empty."""
        topic = key.rpartition("/")[2]
        if topic in TOPICS:
            full = {"percentage": 1.0} if topic == "battery_state" else {}
            return json.dumps(TOPICS[topic](**full).model_dump()).encode()
        return json.dumps({"features": []}).encode()


class Places:
    """A world in which any place is somewhere."""

    def pose(self, _name):
        return pose_at(1.0, 2.0)


class Same(Behaviour):
    """Returns the same status each time."""

    def __init__(self, status):
        super().__init__("child")
        self._status = status

    def update(self):
        return self._status


@pytest.fixture(autouse=True)
def _board():
    with Board().in_use:
        yield


def each():
    """Give each node's tag and class."""
    return registry().items()


def each_built():
    """Give each node four times, with children that return a status; the case's name, the client, and the node."""
    for (tag, kind), status in product(each(), ENDS):
        client = Robot()
        with case(f"{tag}, children {status.name}"), Board().in_use:
            yield f"{tag}, children {status.name}", client, build(kind, client, status)


def build(kind, client, status):
    """Return a node, with children that return a status, as an XML file would use it; ready to be ticked."""
    scripts = {attribute: parse("entry := 1") for attribute in getattr(kind, "SCRIPTS", ())}
    used = kind.bind(scripts) if scripts else kind
    if issubclass(kind, Decorator):
        node = used("node", Same(status))
    else:
        node = used("node")
        for _ in range(getattr(kind, "least", 0)):
            node.add_child(Same(status))
    needed = {port: info for port, info in used.INPUTS.items() if info.required and info.default_value is None}
    node.setup_ports({port: f"/values/{port}" for port in needed})
    for port, information in needed.items():
        Blackboard.set(f"/values/{port}", VALUES[information.kind.name])
    known = {"directory": Directory.from_info(client.info()), "topics": Topics(client, asks=True)}
    for one in list(node.iterate()):
        one.setup(client=client, robot="wall_e", wake=lambda: None, places=Places(), **known)
    return node


def test_it_says_what_it_does():
    for tag, kind in each():
        others = [base.__doc__ for base in kind.__mro__[1:] if kind.__module__ != base.__module__]

        assert kind.__doc__ not in (None, *others), tag


def test_its_ports_are_described():
    for tag, kind in each():
        for port, information in {**kind.INPUTS, **kind.OUTPUTS}.items():
            default = information.default_value

            assert information.kind.name, (tag, port)
            assert information.description, (tag, port)
            assert default is None or information.kind.holds(default) or str(default).startswith("{"), (tag, port)


def test_its_keys_are_ports():
    for tag, kind in each():
        assert {*getattr(kind, "KEYS", ())} <= {*kind.INPUTS, *kind.OUTPUTS}, tag


@pytest.mark.parametrize("folder", [actions, conditions, controls, decorators], ids=lambda folder: folder.__name__)
def test_nodes_are_where_they_belong(folder):
    nodes = [node for family in discover(folder, "FAMILY", Family).values() for node in family.nodes.values()]

    assert {folder is controls} == {issubclass(node, Composite) for node in nodes}
    assert {folder is decorators} == {issubclass(node, Decorator) for node in nodes}


def test_a_tag_is_here_or_not():
    assert set() == {*registry()} & {*UNSUPPORTED}


def test_it_can_be_halted_and_begun_again():
    for name, client, node in each_built():
        with case(name):
            for now in (0.0, 0.5, 1.0, 60.0):
                with simulated_time(now):
                    node.tick_once()
                    node.tick_once()
                    node.stop(Status.INVALID)

                assert {Status.INVALID} == {one.status for one in node.iterate()}
                assert all(goal.canceled for goal in client.goals)


def test_it_is_due_later():
    for name, _, node in each_built():
        with case(name):
            now = 0.25
            for _ in range(10):
                with simulated_time(now):
                    node.tick_once()
                if node.status is not Status.RUNNING:
                    break
                after = due(node, now, 1.0).time
                assert after > now
                now = min(after, now + 10.0)


def test_what_it_leaves_running_runs_with_it():
    for name, _, node in each_built():
        with case(name):
            with simulated_time(0.0):
                node.tick_once()

            assert node.status is Status.RUNNING or not [one for one in node.children if one.status is Status.RUNNING]
