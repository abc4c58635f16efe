"""Parallel and ParallelAll, sentence by sentence of BehaviorTree.CPP's documentation."""

from __future__ import annotations

import pytest

from bt_controller.core.node import PortError
from bt_controller.nodes.controls.sequences import Parallel, ParallelAll, Sequence


@pytest.fixture
def given(node, tree, told):
    """Return what makes a tree of a control with leaves that return these statuses; the leaves come after it."""

    def make(kind, *statuses, **ports):
        leaves = [told(each, f"leaf{number}") for number, each in enumerate(statuses)]
        return tree(node(kind, *leaves, **ports)), *leaves

    return make


def test_by_default_all_children_have_to_succeed(given):
    root, *leaves = given(Parallel, "S", "RS", "RRS")

    assert "RRS" == root.ticks(0, 1, 2)
    assert [1, 2, 3] == [leaf.ticks for leaf in leaves]


def test_one_failure_is_enough_if_nothing_is_said(given):
    root, first, _, last = given(Parallel, "R", "RF", "R")

    assert "RF" == root.ticks(0, 1)
    assert (1, 1) == (first.halts, last.halts)


def test_it_succeeds_when_so_many_have(given):
    root, first, _, _, last = given(Parallel, "R", "RS", "S", "R", success_count="2")

    assert "RS" == root.ticks(0, 1)
    assert (1, 1) == (first.halts, last.halts)
    assert 1 == last.ticks


def test_it_fails_when_so_many_have(given):
    root, *_ = given(Parallel, "F", "RF", "R", success_count="1", failure_count="2")

    assert "RF" == root.ticks(0, 1)


def test_a_negative_number_counts_from_the_end(given):
    """-1 is all of them, -2 all but one."""
    all_but_one, *_ = given(Parallel, "S", "S", "R", success_count="-2")
    all_fail, *_ = given(Parallel, "F", "F", "RF", success_count="1", failure_count="-1")

    assert "S" == all_but_one.tick()
    assert "F" == given(Parallel, "F", "F", "F", success_count="1", failure_count="-1")[0].tick()
    assert "RF" == all_fail.ticks(0, 1)


def test_it_fails_when_it_can_t_succeed_any_more(given):
    root, *_ = given(Parallel, "F", "R", "R", success_count="3", failure_count="2")

    assert "F" == root.tick()


def test_skipped_children_count_beside_a_negative_number(given):
    forgiving, *_ = given(Parallel, "S", "-", success_count="-1")
    strict, *_ = given(Parallel, "S", "-", success_count="2")

    assert "S" == forgiving.tick()
    assert "R" == strict.tick()


def test_skipped_children_are_ticked_again(given):
    """They may have something to do then."""
    root, _, skipped = given(Parallel, "S", "-S", success_count="2")

    assert "RS" == root.ticks(0, 1)
    assert 2 == skipped.ticks


@pytest.mark.parametrize("kind", [Parallel, ParallelAll])
def test_it_is_skipped_if_all_children_are(given, kind):
    root, *_ = given(kind, "-", "-")

    assert "-" == root.tick()


@pytest.mark.parametrize(
    ("kind", "port"), [(Parallel, "success_count"), (Parallel, "failure_count"), (ParallelAll, "max_failures")]
)
def test_more_than_there_are_is_an_error(given, kind, port):
    root, *_ = given(kind, "S", "S", **{port: "3"})

    with pytest.raises(PortError, match=rf"port '{port}': 3 of 2 children is never reached"):
        root.tick()


@pytest.mark.parametrize("kind", [Parallel, ParallelAll])
def test_a_halt_halts_what_runs(given, kind):
    root, first, second = given(kind, "S", "R")
    root.tick()
    root.halt()
    root.tick()

    assert (2, 2, 1) == (first.ticks, second.ticks, second.halts)


def test_all_waits_for_all(given):
    root, *leaves = given(ParallelAll, "F", "RRS", "S")

    assert "RRF" == root.ticks(0, 1, 2)
    assert [1, 3, 1] == [leaf.ticks for leaf in leaves]


def test_all_succeeds_with_fewer_failures_than_its_port_says(given):
    fewer, *_ = given(ParallelAll, "F", "S", "S", max_failures="2")
    as_many, *_ = given(ParallelAll, "F", "F", "S", max_failures="2")
    not_all, *_ = given(ParallelAll, "F", "F", "S", max_failures="-1")

    assert ("S", "F", "S") == (fewer.tick(), as_many.tick(), not_all.tick())


def test_all_does_not_wait_for_skipped_children(given):
    root, *_ = given(ParallelAll, "-", "RS")

    assert "RS" == root.ticks(0, 1)


@pytest.mark.parametrize("kind", [Parallel, ParallelAll])
def test_what_has_not_ended_is_looked_at(node, tree, told, kind):
    ended = tree(node(kind, node(Sequence, told("S")), told("R")))
    ended.tick()
    skipped = tree(node(kind, node(Sequence, told("-")), told("R")))
    skipped.tick()

    assert float("inf") == ended.due()
    assert 1.0 == skipped.due()


@pytest.mark.parametrize("kind", [Parallel, ParallelAll])
def test_what_is_idle_begins_with_itself(node, told, kind):
    assert [] == node(kind, told("R")).next_ticked()
