"""``_skipIf``, ``_onSuccess`` and so on, sentence by sentence of BehaviorTree.CPP's documentation."""

from __future__ import annotations

import pytest

from bt_controller.scripting.parser import parse
from bt_controller.scripting.scripted import conditioned


@pytest.fixture
def given(node, tree, told):
    """Return what makes a tree of one leaf with scripts; the leaf is its second result."""

    def make(statuses="S", **scripts):
        leaf = told(statuses)
        kind = conditioned({attribute: parse(text) for attribute, text in scripts.items()})
        return tree(node(kind, leaf)), leaf

    return make


@pytest.mark.parametrize(("attribute", "status"), [("_failureIf", "F"), ("_successIf", "S"), ("_skipIf", "-")])
def test_a_condition_says_how_the_node_ends(given, attribute, status):
    root, leaf = given("R", **{attribute: "true"})

    assert status == root.tick()
    assert 0 == leaf.ticks


@pytest.mark.parametrize("attribute", ["_failureIf", "_successIf", "_skipIf"])
def test_a_condition_that_is_false_changes_nothing(given, attribute):
    root, _ = given("RS", **{attribute: "1 > 2"})

    assert "RS" == root.ticks(0, 1)


def test_failure_comes_before_success_and_success_before_skipping(given):
    """The order is BehaviorTree.CPP's, not the file's."""
    three, _ = given(_skipIf="true", _successIf="true", _failureIf="true")
    two, _ = given(_skipIf="true", _successIf="true")

    assert "F" == three.tick()
    assert "S" == two.tick()


def test_conditions_are_looked_at_when_the_node_is_idle_only(given, board):
    board["/stop"] = False
    root, leaf = given("R", _skipIf="stop")
    root.tick()
    board["/stop"] = True

    assert "R" == root.tick()
    assert 0 == leaf.halts


def test_conditions_are_looked_at_again_after_a_halt(given, board):
    board["/stop"] = False
    root, _ = given("R", _skipIf="stop")
    root.tick()
    root.halt()
    board["/stop"] = True

    assert "-" == root.tick()


def test_what_has_ended_is_not_idle(given, board):
    board["/stop"] = False
    root, leaf = given("S", _failureIf="stop", _while="!stop")
    root.tick()
    board["/stop"] = True

    assert "S" == root.tick()
    assert 2 == leaf.ticks


def test_while_skips_what_would_begin(given):
    root, leaf = given("S", _while="false")

    assert "-" == root.tick()
    assert 0 == leaf.ticks


def test_while_halts_what_runs(given, board):
    board["/go"] = True
    root, leaf = given("R", _while="go")
    root.tick()
    board["/go"] = False

    assert "-" == root.tick()
    assert (1, 1) == (leaf.ticks, leaf.halts)


def test_while_runs_the_script_for_halting(given, board):
    board["/go"], board["/halts"] = True, 0
    root, _ = given("R", _while="go", _onHalted="halts += 1")
    root.tick()
    board["/go"] = False
    root.tick()

    assert 1 == board["/halts"]


def test_while_has_to_be_looked_at(given):
    watched, _ = given("R", _while="true")
    watched.tick()
    unwatched, _ = given("R", _skipIf="false")
    unwatched.tick()

    assert 1.0 == watched.due()
    assert float("inf") == unwatched.due()


def test_a_script_follows_each_end(given, board):
    scripts = {"_onSuccess": "log := 'success'", "_onFailure": "log := 'failure'", "_post": "log = log .. ', done'"}
    succeeding, _ = given("S", **scripts)
    succeeding.tick()
    success = board["/log"]
    failing, _ = given("F", **scripts)
    failing.tick()

    assert ("success, done", "failure, done") == (success, board["/log"])


def test_a_script_follows_what_a_condition_said(given, board):
    root, _ = given("S", _failureIf="true", _onFailure="log := 'failure'")
    root.tick()

    assert "failure" == board["/log"]


@pytest.mark.parametrize("statuses", ["R", "-"])
def test_no_script_follows_what_has_not_ended(given, board, statuses):
    board["/log"] = ""
    root, _ = given(statuses, _onSuccess="log = 's'", _onFailure="log = 'f'", _post="log = 'p'")
    root.tick()

    assert "" == board["/log"]


def test_a_script_follows_a_halt(given, board):
    board["/halts"] = 0
    running, leaf = given("R", _onHalted="halts += 1")
    running.tick()
    running.halt()
    ended, _ = given("S", _onHalted="halts += 1")
    ended.tick()
    ended.halt()

    assert (1, 1) == (leaf.halts, board["/halts"])


def test_scripts_share_entries(given, board):
    root, leaf = given("RS", _skipIf="runs > 2", _onSuccess="runs += 1")
    board["/runs"] = 2
    statuses = root.ticks(0, 1)
    root.halt()

    assert "RS" == statuses
    assert "-" == root.tick()
    assert 2 == leaf.ticks
