"""IfThenElse, WhileDoElse, Switch and TryCatch, sentence by sentence of BehaviorTree.CPP's documentation."""

from __future__ import annotations

import pytest

from bt_controller.nodes import registry
from bt_controller.nodes.controls.branches import IfThenElse, TryCatch, WhileDoElse

NEVER = float("inf")


@pytest.fixture
def given(node, tree, told):
    """Return what makes a tree of a control with leaves that return these statuses; the leaves come after it."""

    def make(kind, *statuses, **ports):
        leaves = [told(each, f"leaf{number}") for number, each in enumerate(statuses)]
        return tree(node(kind, *leaves, **ports)), *leaves

    return make


@pytest.mark.parametrize("kind", [IfThenElse, WhileDoElse])
def test_a_condition_says_which_child_is_meant(given, kind):
    then, *_ = given(kind, "S", "S", "F")
    otherwise, *_ = given(kind, "F", "S", "F")

    assert ("S", "F") == (then.tick(), otherwise.tick())


@pytest.mark.parametrize("kind", [IfThenElse, WhileDoElse])
def test_without_a_third_child_it_fails_with_the_condition(given, kind):
    root, _, then = given(kind, "F", "S")

    assert "F" == root.tick()
    assert 0 == then.ticks


@pytest.mark.parametrize("kind", [IfThenElse, WhileDoElse])
def test_a_condition_may_take_its_time(given, kind):
    root, _, then = given(kind, "RS", "S")

    assert "RS" == root.ticks(0, 1)
    assert 1 == then.ticks


@pytest.mark.parametrize("kind", [IfThenElse, WhileDoElse])
@pytest.mark.parametrize("statuses", [("-", "S"), ("S", "-")])
def test_it_is_skipped_if_its_condition_or_what_is_meant_is(given, kind, statuses):
    root, *_ = given(kind, *statuses)

    assert "-" == root.tick()


def test_if_does_not_look_again_while_what_is_meant_runs(given):
    root, condition, then, otherwise = given(IfThenElse, "SF", "RS", "S")

    assert "RS" == root.ticks(0, 1)
    assert (1, 2, 0) == (condition.ticks, then.ticks, otherwise.ticks)


def test_if_looks_again_when_it_begins_again(given):
    root, condition, then, otherwise = given(IfThenElse, "SF", "S", "F")

    assert "SF" == root.ticks(0, 1)
    assert (2, 1, 1) == (condition.ticks, then.ticks, otherwise.ticks)


def test_while_looks_again_at_each_tick(given):
    root, condition, do, otherwise = given(WhileDoElse, "SFS", "R", "R")

    assert "RRR" == root.ticks(0, 1, 2)
    assert 3 == condition.ticks
    assert (2, 1, 1, 1) == (do.ticks, do.halts, otherwise.ticks, otherwise.halts)


def test_while_halts_what_runs_when_nothing_else_is_meant(given):
    root, _, do = given(WhileDoElse, "SF", "R")

    assert "RF" == root.ticks(0, 1)
    assert 1 == do.halts


def test_while_leaves_what_runs_alone_while_its_condition_takes_time(given):
    root, _, do = given(WhileDoElse, "SRS", "R")

    assert "RRR" == root.ticks(0, 1, 2)
    assert (2, 0) == (do.ticks, do.halts)


def test_while_has_its_condition_looked_at(node, tree, told):
    asked = tree(node(WhileDoElse, node(IfThenElse, told("S"), told("S")), told("R")))
    asked.tick()
    not_asked = tree(node(IfThenElse, node(IfThenElse, told("S"), told("S")), told("R")))
    not_asked.tick()

    assert (1.0, NEVER) == (asked.due(), not_asked.due())


@pytest.mark.parametrize(
    ("value", "chosen"), [("a", 0), ("2", 1), (2, 1), (2.0, 1), ("2.0", 1), (True, 2), ("b", 3), ([], 3)]
)
def test_a_switch_ticks_the_child_whose_case_equals_the_variable(given, board, value, chosen):
    board["/mode"] = value
    root, *leaves = given(
        registry()["Switch3"], "S", "S", "S", "S", variable="{mode}", case_1="a", case_2="2", case_3="true"
    )

    assert "S" == root.tick()
    assert [int(number == chosen) for number in range(4)] == [leaf.ticks for leaf in leaves]


def test_a_switch_without_a_value_takes_the_last(given):
    root, *leaves = given(registry()["Switch2"], "S", "S", "F", variable="{mode}", case_1="a", case_2="b")

    assert "F" == root.tick()
    assert [0, 0, 1] == [leaf.ticks for leaf in leaves]


def test_a_switch_halts_the_former_branch(given, board):
    board["/mode"] = "a"
    root, first, second, _ = given(registry()["Switch2"], "R", "S", "F", variable="{mode}", case_1="a", case_2="b")
    before, due = root.tick(), root.due()
    board["/mode"] = "b"

    assert ("R", 1.0, "S") == (before, due, root.tick())
    assert (1, 1, 1) == (first.ticks, first.halts, second.ticks)


def test_a_switch_is_skipped_as_its_child_is(given):
    root, *_ = given(registry()["Switch2"], "-", "S", "S", variable="a", case_1="a", case_2="b")

    assert "-" == root.tick()


@pytest.mark.parametrize("cases", range(2, 7))
def test_a_switch_has_a_child_for_each_case_and_one_more(cases):
    kind = registry()[f"Switch{cases}"]

    assert (cases + 1, cases + 1) == (kind.least, kind.most)
    assert ["variable", *(f"case_{number}" for number in range(1, cases + 1))] == [*kind.INPUTS]


def test_try_is_a_sequence(given):
    root, first, second, catch = given(TryCatch, "S", "RS", "S")

    assert "RS" == root.ticks(0, 1)
    assert (1, 2, 0) == (first.ticks, second.ticks, catch.ticks)


@pytest.mark.parametrize("catch", ["S", "F"])
def test_a_failure_is_caught_and_fails(given, catch):
    root, _, untried, last = given(TryCatch, "F", "S", catch)

    assert "F" == root.tick()
    assert (0, 1) == (untried.ticks, last.ticks)


def test_catching_may_take_time(given):
    root, first, _ = given(TryCatch, "F", "RS")

    assert "RF" == root.ticks(0, 1)
    assert 1 == first.ticks


def test_try_passes_over_skipped_children(given):
    some, *_ = given(TryCatch, "-", "S", "F")
    none, *_ = given(TryCatch, "-", "-", "F")

    assert ("S", "-") == (some.tick(), none.tick())


@pytest.mark.parametrize(("port", "ticks"), [({}, 0), ({"catch_on_halt": "false"}, 0), ({"catch_on_halt": "true"}, 1)])
def test_a_halt_is_caught_if_requested(given, port, ticks):
    root, tried, catch = given(TryCatch, "R", "R", **port)
    root.tick()
    root.halt()

    assert (1, ticks, ticks) == (tried.halts, catch.ticks, catch.halts)


def test_a_halt_while_catching_is_not_caught_again(given):
    root, _, catch = given(TryCatch, "F", "R", catch_on_halt="true")
    root.tick()
    root.halt()

    assert (1, 1) == (catch.ticks, catch.halts)


def test_a_skip_of_a_running_child_is_not_a_halt(given):
    root, _, catch = given(TryCatch, "R-", "S", catch_on_halt="true")

    assert "R-" == root.ticks(0, 1)
    assert 0 == catch.ticks
