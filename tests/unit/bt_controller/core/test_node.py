"""Nodes without a tree: their ports on the blackboard, and the ticks of leaves."""

from __future__ import annotations

from typing import ClassVar

import pytest
from py_trees.blackboard import Blackboard
from py_trees.common import Access, Status

from bt_controller.core.blackboards import Board
from bt_controller.core.node import Leaf
from bt_controller.core.ports import DOUBLE, STRING, Kind, input_port, output_port


class _Sum(Leaf):
    """Reads a number and texts, and writes a number."""

    INPUTS: ClassVar = {
        "number": input_port(DOUBLE, required=False),
        "texts": input_port(Kind("string[]", list, lambda text, _places: text.split(";")), required=False),
    }
    OUTPUTS: ClassVar = {"total": output_port(DOUBLE), "text": output_port(STRING)}

    result: object = Status.SUCCESS

    def update(self):
        return self.result


@pytest.fixture
def node():
    """Return a node whose ports are at /number, /texts and /total, on its own blackboard."""
    with Board().in_use:
        node = _Sum("sum")
        node.setup_ports({"number": "number", "texts": "/texts", "total": "/total"})
        yield node


def test_a_text_is_read_anew_when_another_one_is_written(node):
    read = []
    for text in ("1.5", "1.5", "2.5"):
        Blackboard.set("/number", text)
        read.append(node.read("number"))

    assert [1.5, 1.5, 2.5] == read


def test_a_list_that_was_read_may_be_changed(node):
    """The next reader gets a new list, made from the same text."""
    Blackboard.set("/texts", "a;b")
    node.read("texts").clear()

    assert ["a", "b"] == node.read("texts")


def test_only_outputs_are_written(node):
    """Writing to an unknown port is a bug in the node's class."""
    with pytest.raises(ValueError, match="sum has no output port 'number'; there are total, text"):
        node.write("number", 1.0)


def test_py_trees_clients_see_the_ports(node):
    node.write("total", 3.0)
    client = node.blackboard_client

    assert 3.0 == client.get("total")
    assert client.is_registered("number", Access.READ)
    assert "/total" == client.remappings["/total"]
    assert {"/number", "/texts", "/total"} <= Blackboard.keys()


def test_what_is_no_status_is_invalid(node):
    node.result = None
    node.tick_once()

    assert node.status is Status.INVALID
