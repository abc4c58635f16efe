"""What we rely on in py_trees' parser of XML trees, which is experimental."""

from __future__ import annotations

import inspect
from functools import partial
from importlib.metadata import version
from typing import ClassVar
from xml.etree.ElementTree import fromstring

from py_trees.behaviour import Behaviour
from py_trees.blackboard import Blackboard
from py_trees.common import Status
from py_trees.composites import Sequence
from py_trees.parsers.behaviour_tree_xml import build_bt_index, build_tree_from_xml
from py_trees.ports import CONST_PREFIX, DOT_REPLACEMENT, PortInformation, PortsMixin


class Probe(PortsMixin, Behaviour, register=False):
    """Has one port of each direction."""

    INPUT_PORTS: ClassVar = {"x": PortInformation(str | object, required=False)}
    OUTPUT_PORTS: ClassVar = {"y": PortInformation(object, required=False)}

    def __init__(self, name, behaviour_class_name):
        super().__init__(name, behaviour_class_name=behaviour_class_name)
        self.tag = behaviour_class_name

    def update(self):
        """Do nothing."""
        return Status.SUCCESS


def _built(text, table=None):
    root = fromstring(f"<root>{text}</root>")
    for element in root.iter("Probe"):
        element.tag = "#1"
    trees = build_bt_index(root)
    return build_tree_from_xml(trees["A"], table or {}, {"#1": partial(Probe)}, trees)


def _key(node, port):
    client = node.blackboard_client
    return client.remappings[client.absolute_name(port)]


def test_it_is_the_version_that_we_know():
    """Another one is to be looked at before it is allowed."""
    assert version("py_trees").startswith("2.6.")


def test_the_arguments_are_those_that_we_give():
    """Element, table of keys, classes by tag, trees by ID."""
    assert list(inspect.signature(build_tree_from_xml).parameters)[:4] == [
        "elem",
        "remapping_table",
        "node_registry",
        "bt_index",
    ]


def test_a_tag_may_be_any_text_and_a_class_may_be_wrapped():
    """So that a node with scripts can have a class of its own, and constructors need not be looked through."""
    root = _built('<BehaviorTree ID="A"><Probe name="p"/></BehaviorTree>')

    assert (type(root), root.tag, root.name) == (Probe, "#1", "p")


def test_keys_lead_to_the_namespace_of_their_tree():
    """A subtree shares what is mentioned; its name is that of its namespace."""
    root = _built(
        '<BehaviorTree ID="A"><SubTree ID="B" name="sub" p="{q}"/></BehaviorTree>'
        '<BehaviorTree ID="B"><Probe name="p" x="{p}" y="{r}"/></BehaviorTree>'
    )

    assert (_key(root, "x"), _key(root, "y")) == ("/q", "/sub/r")


def test_keys_of_the_outermost_tree_can_be_said_beforehand():
    """The table of the outermost tree may be filled already; a key may begin with @."""
    root = _built('<BehaviorTree ID="A"><Probe name="p" x="{@k}"/></BehaviorTree>', {"@k": "/k"})

    assert _key(root, "x") == "/k"


def test_a_value_is_stored_under_a_key_that_marks_it_as_one():
    """Displays leave such keys out."""
    root = _built('<BehaviorTree ID="A"><Probe name="p" x="1.5/a"/></BehaviorTree>')

    assert _key(root, "x").endswith("__const")
    assert Blackboard.storage[_key(root, "x")] == "1.5/a"
    assert (CONST_PREFIX, DOT_REPLACEMENT) == ("__const_", "__DOT__")


def test_iterate_yields_children_before_their_parents():
    """Names and places are handed out in that order."""
    leaves = [Probe("a", ""), Probe("b", "")]
    root = Sequence("s", memory=True, children=leaves)

    assert list(root.iterate()) == [*leaves, root]
