"""Nodes for entries of the blackboard, by BehaviorTree.CPP's documentation."""

from __future__ import annotations

import pytest

from bt_controller.core.node import PortError
from bt_controller.nodes import registry
from bt_controller.nodes.actions.btcpp import AlwaysFailure, AlwaysSuccess, Script, SetBlackboard, UnsetBlackboard
from bt_controller.nodes.conditions.blackboard import ScriptCondition, WasEntryUpdated
from bt_controller.nodes.decorators.gates import SkipUnlessUpdated, WaitValueUpdate
from bt_controller.scripting.parser import ScriptError, parse

NEVER = float("inf")


def test_always(node, tree):
    assert ("S", "F") == (tree(node(AlwaysSuccess)).tick(), tree(node(AlwaysFailure)).tick())


def test_a_value_is_put_into_an_entry(node, tree, board):
    root = tree(node(SetBlackboard, value="42", output_key="{answer}"))

    assert "S" == root.tick()
    assert "42" == board["/answer"]


def test_an_entry_is_copied_into_another(node, tree, board):
    board["/source"] = pose = object()
    root = tree(node(SetBlackboard, value="{source}", output_key="{target}"))

    assert "S" == root.tick()
    assert board["/target"] is pose


def test_an_entry_without_a_value_can_t_be_copied(node, tree, board):
    root = tree(node(SetBlackboard, value="{source}", output_key="{target}"))

    assert "F" == root.tick()
    assert "/target" not in board
    assert "SetBlackboard1: port 'value' has no value yet" == root.root.feedback_message


def test_an_entry_is_removed(node, tree, board):
    board["/answer"] = 42
    root = tree(node(UnsetBlackboard, key="{answer}"))

    assert "SS" == root.ticks(0, 1)
    assert "/answer" not in board


def test_a_key_may_be_written_without_braces():
    assert ("output_key",) == SetBlackboard.KEYS
    assert ("key",) == UnsetBlackboard.KEYS
    assert ("entry",) == WasEntryUpdated.KEYS == SkipUnlessUpdated.KEYS


def test_a_script_changes_the_blackboard(node, tree, board):
    root = tree(node(Script.bind({"code": parse("a := 1; b := a + 1; false")})))

    assert "S" == root.tick()
    assert (1, 2) == (board["/a"], board["/b"])


def test_a_script_reads_entries_with_any_name(node, tree, board):
    board["/name"], board["/id"] = 1, 2
    root = tree(node(Script.bind({"code": parse("name += 1; read := id + @get")})))
    board["/get"] = 3
    root.tick()

    assert (2, 5) == (board["/name"], board["/read"])


def test_a_script_that_can_t_be_run_is_an_error(node, tree):
    made = node(Script.bind({"code": parse("a = 1")}))
    made.origin = "tree.xml:7"

    with pytest.raises(ScriptError, match=r"^Script1 \(tree.xml:7\): script 'a = 1': no entry 'a'"):
        tree(made).tick()


@pytest.mark.parametrize(("code", "status"), [("x > 1", "S"), ("x < 1", "F"), ("x", "S"), ("x - 2", "F")])
def test_a_script_is_a_condition(node, tree, board, code, status):
    board["/x"] = 2
    root = tree(node(ScriptCondition.bind({"code": parse(code)})))

    assert status == root.tick()
    assert 1.0 == root.due()


def test_a_condition_that_is_neither_true_nor_false_is_an_error(node, tree, board):
    board["/x"] = []
    root = tree(node(ScriptCondition.bind({"code": parse("x")})))

    with pytest.raises(ScriptError, match="script 'x': a list is neither true nor false"):
        root.tick()


def test_an_update_is_seen_once(node, tree, board):
    root = tree(node(WasEntryUpdated, entry="{goal}"))
    statuses = root.tick()
    for _ in range(2):
        board["/goal"] = 1
        statuses += root.ticks(1, 2)

    assert "FSFSF" == statuses
    assert 1.0 * 3 == root.due()


def test_what_was_removed_was_not_updated(node, tree, board):
    board["/goal"] = 1
    root = tree(node(WasEntryUpdated, entry="{goal}"))
    del board["/goal"]

    assert "F" == root.tick()


@pytest.mark.parametrize(("kind", "otherwise"), [(SkipUnlessUpdated, "-"), (WaitValueUpdate, "R")])
def test_a_child_is_ticked_for_each_update(node, tree, told, board, kind, otherwise):
    leaf = told("SF")
    root = tree(node(kind, leaf, entry="{goal}"))
    statuses = root.tick()
    for value in (1, 1):
        board["/goal"] = value
        statuses += root.ticks(0, 0)

    assert f"{otherwise}S{otherwise}F{otherwise}" == statuses
    assert 2 == leaf.ticks
    assert 1.0 == root.due()


@pytest.mark.parametrize("kind", [SkipUnlessUpdated, WaitValueUpdate])
def test_a_child_that_runs_is_ticked_without_an_update(node, tree, told, board, kind):
    board["/goal"] = 1
    leaf = told("RRS")
    root = tree(node(kind, leaf, entry="{goal}"))
    root.tick()
    board["/goal"] = 2
    root.tick()

    assert NEVER == root.due()
    assert "S" == root.tick()
    assert (3, 1) == (leaf.ticks, leaf.begun)


@pytest.fixture
def loop(node, tree, told):
    """Return what makes a tree of a loop over a leaf; the leaf comes after it."""

    def make(tag, statuses, **ports):
        leaf = told(statuses)
        return tree(node(registry()[tag], leaf, value="{value}", **ports)), leaf

    return make


def test_a_loop_has_a_turn_for_each_value(loop, board):
    queue = board["/queue"] = [1, 2, 3]
    root, leaf = loop("LoopInt", "S", queue="{queue}")

    assert "S" == root.tick()
    assert ([], 3, 3) == (queue, leaf.ticks, board["/value"])


def test_a_loop_waits_for_its_child(loop, board):
    board["/queue"] = ["a", "b"]
    root, leaf = loop("LoopString", "RSRS", queue="{queue}")

    assert ("R", "a", NEVER) == (root.tick(), board["/value"], root.due())
    assert ("R", "b") == (root.tick(), board["/value"])
    assert "S" == root.tick()
    assert 2 == leaf.begun


def test_a_loop_fails_with_its_child(loop, board):
    queue = board["/queue"] = [1.5, 2.5, 3.5]
    root, _ = loop("LoopDouble", "SF", queue="{queue}")

    assert "F" == root.tick()
    assert [3.5] == queue


def test_a_loop_goes_on_after_a_skipped_child(loop, board):
    board["/queue"] = [True, False]
    root, leaf = loop("LoopBool", "-S", queue="{queue}")

    assert "S" == root.tick()
    assert 2 == leaf.ticks


@pytest.mark.parametrize(
    ("port", "status"), [({}, "S"), ({"if_empty": "FAILURE"}, "F"), ({"if_empty": "SKIPPED"}, "-")]
)
def test_an_empty_queue_says_how_the_loop_ends(loop, board, port, status):
    board["/queue"] = []
    empty, _ = loop("LoopInt", "S", queue="{queue}", **port)
    unwritten, _ = loop("LoopInt", "S", queue="{other}", **port)

    assert (status, status) == (empty.tick(), unwritten.tick())


def test_a_queue_may_be_a_text(loop, board):
    root, leaf = loop("LoopDouble", "S", queue="1;2.5")

    assert "SS" == root.ticks(0, 1)
    assert (4, 2.5) == (leaf.ticks, board["/value"])


@pytest.mark.parametrize("tag", ["LoopInt", "LoopBool", "LoopDouble", "LoopString"])
def test_an_empty_text_is_an_empty_queue(loop, tag):
    root, leaf = loop(tag, "S", queue=" ", if_empty="FAILURE")

    assert ("F", 0) == (root.tick(), leaf.ticks)


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
