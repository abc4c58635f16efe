"""What a tree looks like."""

from __future__ import annotations

import io
import json

import pytest
from py_trees.behaviours import Success
from py_trees.common import ParallelPolicy
from py_trees.composites import Parallel, Selector, Sequence
from py_trees.decorators import Inverter
from py_trees.display import unicode_tree

from bt_controller.display import JsonDisplay, LiveDisplay, PlainDisplay
from bt_controller.snapshot import Snapshot, nodes_of


def snapshot(message="", *, tick=1):
    """Return a tree of one behaviour after a tick."""
    leaf = Success("Leaf")
    leaf.tick_once()
    leaf.feedback_message = message
    return Snapshot("wall_e", 1.5, tick, nodes_of(leaf))


def test_a_tree_is_drawn_as_py_trees_draws_it():
    """Users know these symbols."""
    root = Parallel(
        "Parallel",
        policy=ParallelPolicy.SuccessOnAll(),
        children=[
            Sequence("Remembers", memory=True, children=[Success("A")]),
            Sequence("Forgets", memory=False, children=[Inverter("Not", Success("B"))]),
            Selector("Chooses", memory=True),
            Selector("Chooses again", memory=False),
        ],
    )

    assert [node.line(status=False) for node in nodes_of(root)] == unicode_tree(root).splitlines()


def test_an_unchanged_tree_is_not_written_again():
    """A tick that changes nothing is no news."""
    out = io.StringIO()
    display = PlainDisplay(out)
    display.show(snapshot("one", tick=1))
    display.show(snapshot("one", tick=2))
    display.show(snapshot("two", tick=3))

    assert out.getvalue() == "wall_e at 1.500 s\n--> Leaf [✓] -- one\n\nwall_e at 1.500 s\n--> Leaf [✓] -- two\n\n"


def test_a_stream_without_unicode_gets_py_trees_ascii_symbols():
    """A log in ASCII is no reason to crash."""
    out = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    PlainDisplay(out).show(snapshot())

    assert out.buffer.getvalue() == b"wall_e at 1.500 s\n--> Leaf [o]\n\n"


def test_json_has_a_line_for_each_change():
    """Programs read the whole tree from one line."""
    out = io.StringIO()
    display = JsonDisplay(out)
    display.show(snapshot("one", tick=1))
    display.show(snapshot("one", tick=2))

    node = {"depth": 0, "symbol": "-->", "kind": "Success", "name": "Leaf", "status": "SUCCESS", "message": "one"}
    expected = {"robot": "wall_e", "sim_time": 1.5, "tick": 1, "status": "SUCCESS", "nodes": [node]}
    assert [json.loads(line) for line in out.getvalue().splitlines()] == [expected]


def test_the_live_display_shows_each_robots_latest_tree():
    """All robots are on the screen at once."""
    display = LiveDisplay()
    for robot, message in (("wall_e", "old"), ("eve", "hers"), ("wall_e", "new")):
        display.show(Snapshot(robot, None, 1, snapshot(message).nodes))

    assert display.text().plain == "wall_e\n--> Leaf [✓] -- new\neve\n--> Leaf [✓] -- hers\n"


@pytest.mark.parametrize("message", ["a\nb", "a\x1bb"])
def test_a_message_can_not_garble_the_terminal(message):
    """What a robot says is shown on its line, and commands nothing."""
    assert snapshot(message).nodes[0].line() == "--> Leaf [✓] -- a b"
