"""IfThenElse, WhileDoElse, Switch and TryCatch, sentence by sentence of BehaviorTree.CPP's documentation."""

from __future__ import annotations

import pytest

from bt_controller.nodes import registry
from bt_controller.nodes.controls.branches import IfThenElse, TryCatch, WhileDoElse
from tests.unit.bt_controller.nodes.conftest import NEVER, Row, rows

BOTH = [IfThenElse, WhileDoElse]
SWITCH = registry()["Switch2"]
CASES = {"variable": "{mode}", "case_1": "a", "case_2": "b"}
CAUGHT = {"catch_on_halt": "true"}


@rows(
    {
        "a condition that succeeds means the second child": Row(BOTH, "S S F", "S"),
        "a condition that fails means the third child": Row(BOTH, "F S F", "F"),
        "without a third child it fails with the condition": Row(BOTH, "F S", "F", ticks="1 0"),
        "a condition may take its time": Row(BOTH, "RS S", "RS", ticks="2 1"),
        "it is skipped with its condition": Row(BOTH, "- S", "-"),
        "it is skipped with what is meant": Row(BOTH, "S -", "-"),
        "if does not look again while what is meant runs": Row(IfThenElse, "SF RS S", "RS", ticks="1 2 0"),
        "if looks again when it begins again": Row(IfThenElse, "SF S F", "SF", ticks="2 1 1"),
        "while looks again at each tick": Row(WhileDoElse, "SFS R R", "RRR", ticks="3 2 1", halts="0 1 1"),
        "while halts what runs when nothing else is meant": Row(WhileDoElse, "SF R", "RF", halts="0 1"),
        "while leaves what runs alone while its condition takes time": Row(
            WhileDoElse, "SRS R", "RRR", ticks="3 2", halts="0 0"
        ),
        "a switch without a value takes the last": Row(SWITCH, "S S F", "F", CASES, ticks="0 0 1"),
        "a switch halts the former branch": Row(
            SWITCH, "R S F", ["R", {"mode": "b"}, "S"], CASES, before={"mode": "a"}, ticks="1 1 0", halts="1 0 0"
        ),
        "a switch has to be looked at": Row(SWITCH, "R S F", "R", CASES, before={"mode": "a"}, due=1.0),
        "a switch is skipped as its child is": Row(SWITCH, "- S S", "-", {**CASES, "variable": "a"}),
        "try is a sequence without its last child": Row(TryCatch, "S RS S", "RS", ticks="1 2 0"),
        "a failure is caught by a success and fails": Row(TryCatch, "F S S", "F", ticks="1 0 1"),
        "a failure is caught by a failure and fails": Row(TryCatch, "F S F", "F", ticks="1 0 1"),
        "catching may take time": Row(TryCatch, "F RS", "RF", ticks="1 2"),
        "try passes over skipped children": Row(TryCatch, "- S F", "S"),
        "try is skipped if all its children are": Row(TryCatch, "- - F", "-"),
        "a halt is not caught": Row(TryCatch, "R R", "R!", ticks="1 0", halts="1 0"),
        "a halt is not caught if the port says so": Row(
            TryCatch, "R R", "R!", {"catch_on_halt": "false"}, ticks="1 0", halts="1 0"
        ),
        "a halt is caught if requested": Row(TryCatch, "R R", "R!", CAUGHT, ticks="1 1", halts="1 1"),
        "a halt while catching is not caught again": Row(TryCatch, "F R", "R!", CAUGHT, ticks="1 1", halts="0 1"),
        "a skip of a running child is not a halt": Row(TryCatch, "R- S", "R-", CAUGHT, ticks="2 0"),
    }
)
def test_branches(behaves, row):
    behaves(row)


def test_while_has_its_condition_looked_at(node, tree, told):
    asked = tree(node(WhileDoElse, node(IfThenElse, told("S"), told("S")), told("R")))
    asked.tick()
    not_asked = tree(node(IfThenElse, node(IfThenElse, told("S"), told("S")), told("R")))
    not_asked.tick()

    assert (1.0, NEVER) == (asked.due(), not_asked.due())


@pytest.mark.parametrize(
    ("value", "ticks"),
    [
        ("a", "1 0 0 0"),
        ("2", "0 1 0 0"),
        (2, "0 1 0 0"),
        (2.0, "0 1 0 0"),
        ("2.0", "0 1 0 0"),
        (True, "0 0 1 0"),
        ("b", "0 0 0 1"),
        ([], "0 0 0 1"),
    ],
)
def test_a_switch_ticks_the_child_whose_case_equals_the_variable(behaves, value, ticks):
    cases = {"variable": "{mode}", "case_1": "a", "case_2": "2", "case_3": "true"}

    behaves(Row(registry()["Switch3"], "S S S S", "S", cases, before={"mode": value}, ticks=ticks))


@pytest.mark.parametrize("cases", range(2, 7))
def test_a_switch_has_a_child_for_each_case_and_one_more(cases):
    kind = registry()[f"Switch{cases}"]

    assert (cases + 1, cases + 1) == (kind.least, kind.most)
    assert ["variable", *(f"case_{number}" for number in range(1, cases + 1))] == [*kind.INPUTS]
