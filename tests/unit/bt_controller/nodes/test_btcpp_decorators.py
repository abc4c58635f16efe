"""Decorators that change or repeat what their child does, by BehaviorTree.CPP's documentation."""

from __future__ import annotations

import pytest

from bt_controller.core.node import PortError
from bt_controller.nodes.decorators.gates import ForceFailure, ForceSuccess, Inverter, Precondition, RunOnce
from bt_controller.nodes.decorators.repetition import KeepRunningUntilFailure, Repeat, RetryUntilSuccessful
from bt_controller.scripting.parser import ScriptError, parse

NEVER = float("inf")


@pytest.fixture
def given(node, tree, told):
    """Return what makes a tree of a decorator with a leaf that returns these statuses; the leaf comes after it."""

    def make(kind, statuses, **ports):
        leaf = told(statuses)
        return tree(node(kind, leaf, **ports)), leaf

    return make


@pytest.mark.parametrize(
    ("kind", "statuses"),
    [(Inverter, "RFS-"), (ForceSuccess, "RSS-"), (ForceFailure, "RFF-")],
    ids=str,
)
def test_results_are_changed(given, kind, statuses):
    root, _ = given(kind, "RSF-")

    assert statuses == root.ticks(0, 1, 2, 3)


@pytest.mark.parametrize("kind", [Inverter, ForceSuccess, ForceFailure])
def test_a_running_child_is_not_looked_at(given, kind):
    root, _ = given(kind, "R")
    root.tick()

    assert NEVER == root.due()


def test_repeat_ticks_its_child_as_often_as_its_port_says(given):
    root, leaf = given(Repeat, "S", num_cycles="3")

    assert "S" == root.tick()
    assert (3, 3) == (leaf.ticks, leaf.begun)


def test_repeat_counts_over_ticks(given):
    root, leaf = given(Repeat, "RSRS", num_cycles="2")

    assert "RRS" == root.ticks(0, 1, 2)
    assert (4, 2) == (leaf.ticks, leaf.begun)


def test_repeat_fails_with_its_child(given):
    root, leaf = given(Repeat, "SFSSS", num_cycles="3")

    assert "FS" == root.ticks(0, 1)
    assert 5 == leaf.ticks


def test_repeat_is_skipped_with_its_child(given):
    root, _ = given(Repeat, "-", num_cycles="3")

    assert "-" == root.tick()


def test_repeat_of_no_cycles_succeeds(given):
    root, leaf = given(Repeat, "F", num_cycles="0")

    assert "S" == root.tick()
    assert 0 == leaf.ticks


def test_repeat_for_ever_ends_with_a_failure_only(given):
    root, leaf = given(Repeat, "SSF", num_cycles="-1")
    statuses, due, last = root.ticks(0, 1), root.due(), root.tick(2)

    assert ("RR", 2.0, "F") == (statuses, due, last)
    assert (3, 3) == (leaf.ticks, leaf.begun)


def test_repeat_for_ever_begins_the_next_turn_where_the_last_ended(given):
    """If the child took time, the next turn begins within its last tick; the node is not looked at each period."""
    root, leaf = given(Repeat, "RSRSR", num_cycles="-1")

    assert "RRR" == root.ticks(0, 1, 2)
    assert (5, 3) == (leaf.ticks, leaf.begun)
    assert NEVER == root.due()


@pytest.mark.parametrize(
    ("kind", "port", "status"), [(Repeat, "num_cycles", "S"), (RetryUntilSuccessful, "num_attempts", "F")]
)
def test_a_thousand_turns_are_enough_for_one_tick(given, kind, port, status):
    """The others have to have their turn, too; the tree is to be ticked again."""
    root, leaf = given(kind, status, **{port: "2500"})
    first, due, ticks = root.tick(), root.due(), leaf.ticks

    assert ("R", 1.0, 1000) == (first, due, ticks)
    assert f"R{status}" == root.ticks(1, 2)
    assert 2500 == leaf.ticks


@pytest.mark.parametrize(
    ("kind", "ports", "statuses"),
    [
        (Repeat, {"num_cycles": "-1"}, "RS"),
        (Repeat, {"num_cycles": "9"}, "RS"),
        (RetryUntilSuccessful, {"num_attempts": "-1"}, "RF"),
        (RetryUntilSuccessful, {"num_attempts": "9"}, "RF"),
        (KeepRunningUntilFailure, {}, "RS"),
    ],
)
def test_a_child_that_ran_and_took_no_time_begins_again_a_period_later(given, kind, ports, statuses):
    """A goal that ends at once must not keep time from going on, however often something else happens at that time."""
    root, leaf = given(kind, statuses + "R", **ports)
    first, due, begun = root.ticks(3, 3, 3), root.due(), leaf.begun

    assert ("RRR", 4.0, 1) == (first, due, begun)
    assert ("R", 2) == (root.tick(4), leaf.begun)


def test_a_last_turn_that_took_no_time_is_the_end(given):
    root, _ = given(RetryUntilSuccessful, "RF", num_attempts="1")

    assert "RF" == root.ticks(3, 3)


def test_repeat_counts_anew_after_a_halt(given):
    root, leaf = given(Repeat, "SRSSS", num_cycles="3")
    root.tick()
    root.halt()

    assert "S" == root.tick()
    assert 5 == leaf.ticks


def test_retry_ticks_its_child_until_it_succeeds(given):
    root, leaf = given(RetryUntilSuccessful, "FFS", num_attempts="5")

    assert "S" == root.tick()
    assert (3, 3) == (leaf.ticks, leaf.begun)


def test_retry_fails_after_as_many_failures_as_its_port_says(given):
    root, leaf = given(RetryUntilSuccessful, "RF", num_attempts="3")

    assert "RF" == root.ticks(0, 1)
    assert 4 == leaf.ticks


def test_retry_for_ever_looks_each_tick(given):
    root, leaf = given(RetryUntilSuccessful, "FFS", num_attempts="-1")
    statuses, due, last = root.ticks(0, 1), root.due(), root.tick(2)

    assert ("RR", 2.0, "S") == (statuses, due, last)
    assert 3 == leaf.ticks


def test_retry_is_skipped_with_its_child(given):
    root, _ = given(RetryUntilSuccessful, "-", num_attempts="3")

    assert "-" == root.tick()


def test_retry_looks_at_its_port_again(given, board):
    board["/attempts"] = 3
    root, leaf = given(RetryUntilSuccessful, "FRF", num_attempts="{attempts}")
    root.tick()
    board["/attempts"] = 2

    assert "F" == root.tick()
    assert 3 == leaf.ticks


def test_keep_running_runs_until_a_failure(given):
    root, leaf = given(KeepRunningUntilFailure, "SR-SF")

    assert "RRRRF" == root.ticks(0, 1, 2, 3, 4)
    assert 5 == leaf.ticks


def test_keep_running_has_to_be_looked_at_where_its_child_has_ended(given):
    ended, _ = given(KeepRunningUntilFailure, "S")
    ended.tick()
    running, _ = given(KeepRunningUntilFailure, "R")
    running.tick()

    assert (1.0, NEVER) == (ended.due(), running.due())


def test_run_once_is_skipped_afterwards(given):
    root, leaf = given(RunOnce, "RF")

    assert "RF--" == root.ticks(0, 1, 2, 3)
    assert 2 == leaf.ticks


def test_run_once_may_return_its_childs_status_again(given):
    root, leaf = given(RunOnce, "RF", then_skip="false")

    assert "RFFF" == root.ticks(0, 1, 2, 3)
    assert 2 == leaf.ticks


def test_run_once_remembers_over_a_halt(given):
    """Once is once; but a child that was halted or skipped has not run."""
    ended, _ = given(RunOnce, "S")
    ended.tick()
    ended.halt()
    halted, _ = given(RunOnce, "RS")
    halted.tick()
    halted.halt()
    skipped, _ = given(RunOnce, "-S")
    skipped.tick()

    assert ("-", "S", "S") == (ended.tick(), halted.tick(), skipped.tick())


@pytest.fixture
def guarded(given):
    """Return what makes a tree of a Precondition with this script."""

    def make(script, statuses, **ports):
        return given(Precondition.bind({"if": parse(script)}), statuses, **ports)

    return make


@pytest.mark.parametrize("status", ["SUCCESS", "FAILURE", "RUNNING", "SKIPPED"])
def test_a_precondition_that_is_false_says_how_the_node_ends(guarded, status):
    root, leaf = guarded("1 > 2", "S", **{"else": status})

    assert {"SUCCESS": "S", "FAILURE": "F", "RUNNING": "R", "SKIPPED": "-"}[status] == root.tick()
    assert 0 == leaf.ticks


def test_a_precondition_fails_if_nothing_is_said(guarded):
    root, _ = guarded("false", "S")

    assert "F" == root.tick()


def test_a_precondition_takes_statuses_only(guarded):
    with pytest.raises(
        PortError, match="port 'else': 'MAYBE' is not a status; expected SUCCESS, FAILURE, RUNNING or SKIPPED"
    ):
        guarded("false", "S", **{"else": "MAYBE"})


def test_a_precondition_is_not_looked_at_while_the_child_runs(guarded, board):
    board["/go"] = True
    root, leaf = guarded("go", "RSS")
    root.tick()
    board["/go"] = False

    assert "SF" == root.ticks(1, 2)
    assert 2 == leaf.ticks


def test_a_precondition_that_runs_has_to_be_looked_at(guarded):
    waiting, _ = guarded("false", "S", **{"else": "RUNNING"})
    waiting.tick()
    running, _ = guarded("true", "R")
    running.tick()

    assert (1.0, NEVER) == (waiting.due(), running.due())


def test_a_precondition_without_a_value_is_an_error(guarded):
    root, _ = guarded("missing > 1", "S")

    with pytest.raises(ScriptError, match=r"^Precondition1: script 'missing > 1': 'missing' has no value"):
        root.tick()


def test_an_entry_of_a_script_is_not_named_as_a_port():
    with pytest.raises(ScriptError, match=r"script 'else > 1': 'else' is a port of Precondition, not an entry"):
        Precondition.bind({"if": parse("else > 1")})
