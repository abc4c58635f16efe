"""Nodes for entries of the blackboard, by BehaviorTree.CPP's documentation."""

from __future__ import annotations

import pytest

from bt_controller.core.node import PortError
from bt_controller.nodes import registry
from bt_controller.nodes.actions.btcpp import AlwaysFailure, AlwaysSuccess, Script, SetBlackboard, UnsetBlackboard
from bt_controller.nodes.conditions.blackboard import ScriptCondition, WasEntryUpdated
from bt_controller.nodes.decorators.gates import SkipUnlessUpdated, WaitValueUpdate
from bt_controller.scripting.parser import ScriptError, parse
from tests.unit.bt_controller.nodes.conftest import NEVER, Row, rows


def script(code, kind=Script):
    return kind.bind({"code": parse(code)})


POSE = object()
COPY = {"value": "{source}", "output_key": "{target}"}
GOAL = {"entry": "{goal}"}
QUEUE = {"queue": "{queue}", "value": "{value}"}
LOOPS = registry()
DONE = {"goal": 1}
UPDATED = [SkipUnlessUpdated, WaitValueUpdate]


@rows(
    {
        "AlwaysSuccess": Row(AlwaysSuccess, "", "S"),
        "AlwaysFailure": Row(AlwaysFailure, "", "F"),
        "a value is put into an entry": Row(
            SetBlackboard, "", "S", {"value": "42", "output_key": "{answer}"}, after={"answer": "42"}
        ),
        "an entry is copied into another": Row(
            SetBlackboard, "", "S", COPY, before={"source": POSE}, after={"target": POSE}
        ),
        "an entry is removed if it is there": Row(
            UnsetBlackboard, "", "SS", {"key": "{answer}"}, before={"answer": 42}, after={"answer": None}
        ),
        "a script changes the blackboard whatever its value is": Row(
            script("a := 1; b := a + 1; false"), "", "S", after={"a": 1, "b": 2}
        ),
        "a script reads entries with any name": Row(
            script("name += 1; read := id + @get"),
            "",
            "S",
            before={"name": 1, "id": 2, "get": 3},
            after={"name": 2, "read": 5},
        ),
        "an update is seen once": Row(WasEntryUpdated, "", ["F", DONE, "SF", DONE, "SF"], GOAL, due=5.0),
        "a child is skipped without an update": Row(
            SkipUnlessUpdated, "SF", ["-", DONE, "S-", DONE, "F-"], GOAL, ticks="2", due=5.0
        ),
        "a child waits for an update": Row(
            WaitValueUpdate, "SF", ["R", DONE, "SR", DONE, "FR"], GOAL, ticks="2", due=5.0
        ),
        "a child that runs is ticked without an update": Row(
            UPDATED,
            "RRS",
            ["R", {"goal": 2}, "RS"],
            GOAL,
            before={"goal": 1},
            ticks="3",
            begun="1",
        ),
        "a child that runs needs no look": Row(UPDATED, "R", "R", GOAL, before=DONE, due=NEVER),
        "a loop has a turn for each value": Row(
            LOOPS["LoopInt"], "S", "S", QUEUE, before={"queue": [1, 2, 3]}, ticks="3", after={"queue": [], "value": 3}
        ),
        "a loop waits for its child with the value": Row(
            LOOPS["LoopString"], "R", "R", QUEUE, before={"queue": ["a", "b"]}, after={"value": "a"}, due=NEVER
        ),
        "a loop continues with the next value": Row(
            LOOPS["LoopString"], "RSRS", "RRS", QUEUE, before={"queue": ["a", "b"]}, begun="2", after={"value": "b"}
        ),
        "a loop fails with its child": Row(
            LOOPS["LoopDouble"], "SF", "F", QUEUE, before={"queue": [1.5, 2.5, 3.5]}, after={"queue": [3.5]}
        ),
        "a loop goes on after a skipped child": Row(
            LOOPS["LoopBool"], "-S", "S", QUEUE, before={"queue": [True, False]}, ticks="2"
        ),
        "by default a loop succeeds with an empty queue": Row(LOOPS["LoopInt"], "S", "S", QUEUE, before={"queue": []}),
        "a loop may fail with an empty queue": Row(
            LOOPS["LoopInt"], "S", "F", {**QUEUE, "if_empty": "FAILURE"}, before={"queue": []}
        ),
        "a loop may be skipped with an empty queue": Row(
            LOOPS["LoopInt"], "S", "-", {**QUEUE, "if_empty": "SKIPPED"}, before={"queue": []}
        ),
        "an unwritten queue is empty": Row(LOOPS["LoopInt"], "S", "F", {**QUEUE, "if_empty": "FAILURE"}),
        "an empty text is an empty queue": Row(
            [LOOPS[tag] for tag in ("LoopInt", "LoopBool", "LoopDouble", "LoopString")],
            "S",
            "F",
            {"queue": " ", "if_empty": "FAILURE"},
            ticks="0",
        ),
        "a text is a queue for each run": Row(
            LOOPS["LoopDouble"], "S", "SS", {**QUEUE, "queue": "1;2.5"}, ticks="4", after={"value": 2.5}
        ),
    }
)
def test_entries(behaves, row):
    behaves(row)


def test_an_entry_without_a_value_can_t_be_copied(node, tree, board):
    root = tree(node(SetBlackboard, **COPY))

    assert "F" == root.tick()
    assert "/target" not in board
    assert "SetBlackboard1: port 'value' has no value yet" == root.root.feedback_message


def test_a_key_may_be_written_without_braces():
    assert ("output_key",) == SetBlackboard.KEYS
    assert ("key",) == UnsetBlackboard.KEYS
    assert ("entry",) == WasEntryUpdated.KEYS == SkipUnlessUpdated.KEYS


def test_a_script_that_can_t_be_run_is_an_error(node, tree):
    made = node(script("a = 1"))
    made.origin = "tree.xml:7"

    with pytest.raises(ScriptError, match=r"^Script1 \(tree.xml:7\): script 'a = 1': no entry 'a'"):
        tree(made).tick()


@pytest.mark.parametrize(("code", "status"), [("x > 1", "S"), ("x < 1", "F"), ("x", "S"), ("x - 2", "F")])
def test_a_script_is_a_condition(behaves, code, status):
    behaves(Row(script(code, ScriptCondition), "", status, before={"x": 2}, due=1.0))


def test_a_condition_that_is_neither_true_nor_false_is_an_error(node, tree, board):
    board["/x"] = []
    root = tree(node(script("x", ScriptCondition)))

    with pytest.raises(ScriptError, match="script 'x': a list is neither true nor false"):
        root.tick()


def test_what_was_removed_was_not_updated(node, tree, board):
    board["/goal"] = 1
    root = tree(node(WasEntryUpdated, entry="{goal}"))
    del board["/goal"]

    assert "F" == root.tick()


@pytest.fixture
def loop(node, tree, told):
    """Return what makes a tree of a loop over a leaf; the leaf comes after it."""

    def make(tag, statuses, **ports):
        leaf = told(statuses)
        return tree(node(registry()[tag], leaf, value="{value}", **ports)), leaf

    return make


def test_a_queue_that_becomes_a_text_is_an_error(loop, board):
    board["/queue"] = [1]
    root, _ = loop("LoopInt", "R", queue="{queue}")
    root.tick()
    board["/queue"] = "1;2"

    with pytest.raises(PortError, match="port 'queue' takes a list, got str '1;2'"):
        root.tick()


def test_what_is_put_in_meanwhile_comes_with_the_next_tick(loop, board):
    """A child that fills the queue does not hold up the tree."""
    queue = board["/queue"] = [1]
    root, leaf = loop("LoopInt", "S", queue="{queue}")
    leaf.update = lambda: (queue.append(1), type(leaf).update(leaf))[1]

    assert "RR" == root.ticks(0, 1)
    assert 4 == leaf.ticks
    assert 2.0 == root.due()


@pytest.mark.parametrize(
    ("queue", "error"),
    [
        (["a"], "port 'queue': 'a' is not a whole number"),
        ([1.5], "port 'queue' holds int, got 1.5"),
        (3, "port 'queue' takes a list, got int 3"),
    ],
)
def test_a_queue_of_something_else_is_an_error(loop, board, queue, error):
    board["/queue"] = queue
    root, _ = loop("LoopInt", "S", queue="{queue}")

    with pytest.raises(PortError, match=error):
        root.tick()
