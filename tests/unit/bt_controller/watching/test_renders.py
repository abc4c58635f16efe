"""Pictures of trees in Graphviz's language and as SVG."""

from __future__ import annotations

import shutil

import pytest
from py_trees.behaviours import Failure, Success
from py_trees.composites import Selector, Sequence
from py_trees.decorators import Inverter

from bt_controller.running.snapshot import nodes_of
from bt_controller.watching.renders import dot, svg
from hmrsim_zenoh.errors import BadOptions


def tree():
    """Return a tree of all kinds of shapes."""
    choice = Selector("Choice", memory=False, children=[Inverter("Not", Success("A")), Failure("A")])
    return Sequence("Root", memory=True, children=[choice])


def test_a_graph_has_the_shapes_and_colours_of_py_trees():
    assert [
        '    n0 [label="{-} Root", shape=box, fillcolor=orange];',
        '    n1 [label="[o] Choice", shape=octagon, fillcolor=cyan];',
        "    n0 -> n1;",
        '    n2 [label="Not", shape=ellipse, fillcolor=ghostwhite];',
        "    n1 -> n2;",
        '    n3 [label="A", shape=ellipse, fillcolor=gray];',
        "    n2 -> n3;",
        '    n4 [label="A", shape=ellipse, fillcolor=gray];',
        "    n1 -> n4;",
    ] == dot({"Mission": nodes_of(tree())}).splitlines()[6:-2]


def test_a_graph_may_tell_how_trees_ended():
    root = Failure("Root")
    root.tick_once()

    look = "shape=ellipse, fillcolor=gray, color=red, penwidth=3"
    assert f'    n0 [label="Root\\nfailure", {look}];' in dot({"eve": nodes_of(root)}, statuses=True).splitlines()


def test_each_robot_has_its_graph():
    nodes = nodes_of(Success("Root"))
    lines = dot({"eve": nodes, "wall_e": nodes}).splitlines()

    assert ['    label="eve";', '    label="wall_e";'] == [line for line in lines if line.startswith("    label=")]
    assert ["n0", "n1"] == [line.split()[0] for line in lines if line.startswith("    n")]


def test_any_name_is_quoted():
    assert r'label="a:\"b\"\\n{c}", ' in dot({"x": nodes_of(Success(r'a:"b"\n{c}'))})


@pytest.mark.skipif(shutil.which("dot") is None, reason="Graphviz's dot is not installed")
def test_graphviz_draws_it():
    drawn = svg(dot({"Tür": nodes_of(tree())}))

    assert all(f">{text}</text>" in drawn for text in ("Tür", "{&#45;} Root", "[o] Choice", "Not", "A"))
    assert drawn == svg(dot({"Tür": nodes_of(tree())}))


def test_without_graphviz_it_is_said_what_to_do(monkeypatch):
    monkeypatch.setenv("PATH", "")

    with pytest.raises(BadOptions, match=r"--svg needs Graphviz's `dot`.*apt install graphviz, or use --dot"):
        svg("digraph {}")
