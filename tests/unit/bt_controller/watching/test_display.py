"""Trees as lines, and as JSON."""

from __future__ import annotations

import io
import json
from dataclasses import replace

from py_trees.behaviours import Success

from bt_controller.running.snapshot import Snapshot, nodes_of
from bt_controller.watching.display import JsonDisplay, PlainDisplay


def snapshot(message="", *, tick=1):
    """Return a tree of one behavior after a tick."""
    leaf = Success("Leaf")
    leaf.tick_once()
    leaf.feedback_message = message
    return Snapshot("wall_e", 1.5, tick, nodes_of(leaf))


def test_an_unchanged_tree_is_not_written_again():
    out = io.StringIO()
    display = PlainDisplay(out)
    display.show(snapshot("one", tick=1))
    display.show(snapshot("one", tick=2))
    display.show(snapshot("two", tick=3))

    assert out.getvalue() == "wall_e at 1.500 s\n--> Leaf [✓] -- one\n\nwall_e at 1.500 s\n--> Leaf [✓] -- two\n\n"


def test_a_stream_without_unicode_gets_py_trees_ascii_symbols():
    """A log in ASCII does not crash the display."""
    out = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    PlainDisplay(out).show(snapshot())

    assert out.buffer.getvalue() == b"wall_e at 1.500 s\n--> Leaf [o]\n\n"


def test_a_name_that_a_stream_can_not_encode_does_not_crash():
    out = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    PlainDisplay(out).show(snapshot("Tür"))

    assert b"wall_e at 1.500 s\n--> Leaf [o] -- T?r\n\n" == out.buffer.getvalue()


def test_json_has_a_line_for_each_change():
    out = io.StringIO()
    display = JsonDisplay(out)
    display.show(snapshot("one", tick=1))
    display.show(snapshot("one", tick=2))

    node = {"depth": 0, "symbol": "-->", "kind": "Success", "name": "Leaf", "status": "SUCCESS", "message": "one"}
    expected = {"robot": "wall_e", "sim_time": 1.5, "tick": 1, "status": "SUCCESS", "ended": False, "nodes": [node]}
    assert [json.loads(line) for line in out.getvalue().splitlines()] == [expected]


def test_json_has_changes_of_the_blackboard_only():
    out = io.StringIO()
    display = JsonDisplay(out)
    for tick, known in ((1, {}), (2, {"code": 208}), (3, {"code": 208})):
        display.show(replace(snapshot(tick=tick), blackboard=known))

    lines = [json.loads(line) for line in out.getvalue().splitlines()]
    assert [(1, {}), (2, {"code": 208})] == [(line["tick"], line["blackboard"]) for line in lines]
