"""The kinds of ports, and values of ports in Python trees."""

from __future__ import annotations

import copy
from typing import ClassVar

import pytest
from py_trees.behaviours import Success
from py_trees.blackboard import Blackboard
from py_trees.common import Status

from bt_controller.core.node import Control, Decoration, Leaf, PortError
from bt_controller.core.port_values import node
from bt_controller.core.ports import DOUBLE, INT, PLANNER, POSE, UNSIGNED, Given, input_port, output_port
from bt_controller.nodes import registry
from bt_controller.nodes.controls.nav2 import RecoveryNode
from hmrsim_zenoh.client.places import pose_at


class _Nowhere:
    """Places of which there is none."""

    def pose(self, name):
        """Raise an error that names the place."""
        raise ValueError(f"no place {name!r}; there are none")


def test_an_unknown_given_place_is_reported_as_it_was_given():
    with pytest.raises(ValueError, match=r"^--set goal=nowhere: no place 'nowhere'; there are none$"):
        POSE.read(Given("nowhere", "goal"), _Nowhere())


def test_a_given_text_can_be_copied():
    twin = copy.deepcopy(Given("ward", "goal"))

    assert ("ward", "goal") == (twin, twin.key)


def test_a_text_without_effect_here_is_doubted():
    assert "no robot serves 'Smac'; there are GridBased, graph" == PLANNER.doubt("Smac")
    assert (None, None) == (PLANNER.doubt("graph"), UNSIGNED.doubt("3"))


class Add(Leaf):
    """A node that adds two numbers."""

    INPUTS: ClassVar = {"a": input_port(DOUBLE), "b": input_port(DOUBLE, default=1.0)}
    OUTPUTS: ClassVar = {"sum": output_port(DOUBLE)}

    def update(self):
        self.write("sum", self.read("a") + self.read("b"))
        return Status.SUCCESS


class Pose(Leaf):
    """A node with a required pose."""

    INPUTS: ClassVar = {"pose": input_port(POSE), "times": input_port(INT, default=1)}

    def update(self):
        """Succeed without reading the pose."""
        return Status.SUCCESS


@pytest.mark.parametrize("value", [2.0, 2, "2.0"])
def test_a_port_carries_a_value_or_text_as_in_a_file(value):
    made = node(Add, a=value, sum="{sum}")
    made.setup()
    made.tick_once()

    assert 3.0 == Blackboard.get("sum")


def test_a_port_may_lead_to_the_blackboard():
    Blackboard.set("here", 5.0)
    made = node(Add, a="{here}", b=0.5, sum="{sum}", name="Plus")
    made.setup()
    made.tick_once()

    assert ("Plus", 5.5) == (made.name, Blackboard.get("sum"))


def test_two_nodes_of_one_name_do_not_share_their_values():
    """Each node has its own entries."""
    first, second = node(Add, a=1.0), node(Add, a=2.0)

    assert (1.0, 2.0) == (first.read("a"), second.read("a"))


def test_a_value_may_be_a_message():
    made = node(Pose, pose=pose_at(1.0, 2.0))

    assert pose_at(1.0, 2.0) == made.read("pose")


def test_children_come_first():
    made = node(RecoveryNode, node(Add, a=1), node(Add, a=2), number_of_retries=3)

    assert (["Add", "Add"], 3) == ([child.name for child in made.children], made.read("number_of_retries"))


@pytest.mark.parametrize("tag", registry())
def test_every_node_of_files_can_be_made_so(tag):
    kind = registry()[tag]
    ports = dict.fromkeys((port for port, said in kind.INPUTS.items() if said.required), "1")
    number = kind.least if issubclass(kind, Control) else int(issubclass(kind, Decoration))
    made = node(kind, *[Success(str(child)) for child in range(number)], **ports)

    assert (kind.__name__, number) == (made.name, sum(isinstance(child, Success) for child in made.children))


def test_a_port_that_there_is_not_is_refused():
    with pytest.raises(ValueError, match="Add: no port 'c'; there are a, b, sum"):
        node(Add, a=1.0, c=2.0)


def test_a_port_that_is_needed_has_to_have_a_value():
    with pytest.raises(ValueError, match="Add: port 'a' needs a value"):
        node(Add, b=2.0)


def test_text_that_makes_no_sense_is_an_error_before_the_first_tick():
    with pytest.raises(PortError, match="Pose: port 'times': 'often' is not a whole number"):
        node(Pose, pose="1;2", times="often").setup()
