"""Nodes of the user's own modules."""

from __future__ import annotations

import sys

import pytest

from bt_controller.errors import TreeError
from bt_controller.loading.file_tree import vocabulary
from bt_controller.loading.trees import load
from bt_controller.nodes import registry

MODULE = '''
from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.ports import PortInformation, PortsMixin

from bt_controller.core.node import Leaf
from bt_controller.core.ports import STRING, input_port


class _Hidden(Leaf):
    """Not for files."""


class Greet(Leaf):
    """Greets."""

    INPUTS = {"whom": input_port(STRING)}

    def update(self):
        self.feedback_message = f"hello, {self.read('whom')}"
        return Status.SUCCESS


class Plain(PortsMixin, Behaviour, register=False):
    """A node as py_trees has it."""

    INPUT_PORTS = {"number": PortInformation(float)}
    OUTPUT_PORTS = {"half": PortInformation(float)}

    def update(self):
        self._set_output("half", self.get_input("number") / 2)
        return Status.SUCCESS
'''


@pytest.fixture(autouse=True)
def modules(files, monkeypatch):
    """Put modules into the current folder."""
    monkeypatch.setattr(sys, "path", list(sys.path))
    (files.folder / "bt_test_nodes.py").write_text(MODULE)
    (files.folder / "bt_test_empty.py").write_text("from bt_controller.core.node import Leaf\n")
    (files.folder / "bt_test_taken.py").write_text(
        "from bt_controller.core.node import Leaf\nclass AlwaysSuccess(Leaf):\n    pass\n"
    )
    yield
    for name in [name for name in sys.modules if name.startswith("bt_test_")]:
        del sys.modules[name]


def test_public_classes_with_ports_are_nodes_by_their_names():
    assert {"Greet", "Plain"} == vocabulary(["bt_test_nodes"]).keys() - registry().keys()


@pytest.mark.parametrize(
    ("module", "error"),
    [
        ("bt_test_nowhere", r"^--nodes bt_test_nowhere: no module 'bt_test_nowhere' here \(.*\) or installed$"),
        (
            "bt_test_empty",
            "^--nodes bt_test_empty: it defines no nodes, public subclasses of bt_controller.core.node.Node$",
        ),
        ("bt_test_taken", "^--nodes bt_test_taken: node 'AlwaysSuccess' exists already, in .*; rename the class"),
    ],
)
def test_modules_without_nodes_are_refused(module, error):
    with pytest.raises(TreeError, match=error):
        vocabulary([module])


def test_a_module_that_an_entry_point_has_given_already(monkeypatch):
    known = vocabulary(["bt_test_nodes"])
    monkeypatch.setattr("bt_controller.loading.file_tree.registry", lambda: known)

    assert known == vocabulary(["bt_test_nodes"])


def test_a_file_may_use_them(files):
    files.nodes = vocabulary(["bt_test_nodes"])
    body = '<Sequence><Greet whom="eve"/><Plain number="3" half="{x}"/></Sequence>'

    entries, said = files.ticked(f'<BehaviorTree ID="A">{body}</BehaviorTree>')
    assert (entries, said) == ({"/x": 1.5}, {"Greet": "hello, eve"})


def test_a_value_that_py_trees_cannot_read_is_one_line(files):
    files.nodes = vocabulary(["bt_test_nodes"])

    with pytest.raises(TreeError, match=r"^tree\.xml: ValueError: Cannot convert Value 'three' to type"):
        files.load('<BehaviorTree ID="A"><Plain number="three"/></BehaviorTree>')


def test_load_knows_them(files):
    path = files.write('<BehaviorTree ID="A"><Greet whom="eve"/></BehaviorTree>')

    assert load(path, nodes=["bt_test_nodes"]).build("wall_e").name == "Greet"
    with pytest.raises(TreeError, match="<Greet>: unknown node"):
        load(path)
