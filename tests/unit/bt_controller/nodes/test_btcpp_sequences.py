"""Sequences and fallbacks, sentence by sentence of BehaviorTree.CPP's documentation."""

from __future__ import annotations

import pytest

from bt_controller.nodes.controls.sequences import (
    AsyncFallback,
    AsyncSequence,
    Fallback,
    ReactiveFallback,
    ReactiveSequence,
    Sequence,
    SequenceWithMemory,
)

SEQUENCES = [Sequence, AsyncSequence, SequenceWithMemory, ReactiveSequence]
FALLBACKS = [Fallback, AsyncFallback, ReactiveFallback]
NEVER = float("inf")


@pytest.fixture
def given(node, tree, told):
    """Return what makes a tree of a control with leaves that return these statuses; the leaves come after it."""

    def make(kind, *statuses):
        leaves = [told(each, f"leaf{number}") for number, each in enumerate(statuses)]
        return tree(node(kind, *leaves)), *leaves

    return make


@pytest.mark.parametrize("kind", SEQUENCES)
def test_a_sequence_succeeds_when_all_children_have(given, kind):
    root, *leaves = given(kind, "S", "S", "S")

    assert "S" == root.tick()
    assert [1, 1, 1] == [leaf.ticks for leaf in leaves]


@pytest.mark.parametrize("kind", FALLBACKS)
def test_a_fallback_fails_when_all_children_have(given, kind):
    root, *leaves = given(kind, "F", "F", "F")

    assert "F" == root.tick()
    assert [1, 1, 1] == [leaf.ticks for leaf in leaves]


@pytest.mark.parametrize("kind", SEQUENCES)
def test_a_sequence_fails_with_the_first_child_that_does(given, kind):
    root, _, _, last = given(kind, "S", "F", "S")

    assert "F" == root.tick()
    assert 0 == last.ticks


@pytest.mark.parametrize("kind", FALLBACKS)
def test_a_fallback_succeeds_with_the_first_child_that_does(given, kind):
    root, _, _, last = given(kind, "F", "S", "S")

    assert "S" == root.tick()
    assert 0 == last.ticks


@pytest.mark.parametrize(("kind", "passes"), [(Sequence, "S"), (SequenceWithMemory, "S"), (Fallback, "F")])
def test_what_comes_before_a_running_child_is_not_ticked_again(given, kind, passes):
    root, first, second = given(kind, passes, f"R{passes}")

    assert f"R{passes}" == root.ticks(0, 1)
    assert (1, 2) == (first.ticks, second.ticks)


@pytest.mark.parametrize(("kind", "passes"), [(ReactiveSequence, "S"), (ReactiveFallback, "F")])
def test_what_comes_before_a_running_child_is_ticked_again_if_it_is_reactive(given, kind, passes):
    root, first, second = given(kind, passes, f"R{passes}")

    assert f"R{passes}" == root.ticks(0, 1)
    assert (2, 2) == (first.ticks, first.begun)
    assert (2, 1) == (second.ticks, second.begun)


@pytest.mark.parametrize(("kind", "statuses", "end"), [(ReactiveSequence, "SF", "F"), (ReactiveFallback, "FS", "S")])
def test_a_running_child_is_halted_when_one_before_it_ends_otherwise(given, kind, statuses, end):
    """So a condition that has become false stops what runs."""
    root, _, running = given(kind, statuses, "R")

    assert f"R{end}" == root.ticks(0, 1)
    assert (1, 1) == (running.ticks, running.halts)


@pytest.mark.parametrize(("kind", "passes"), [(ReactiveSequence, "S"), (ReactiveFallback, "F")])
def test_a_running_child_is_halted_when_one_before_it_runs(given, kind, passes):
    root, first, second = given(kind, f"{passes}R", "R")

    assert "RR" == root.ticks(0, 1)
    assert (0, 1) == (first.halts, second.halts)


@pytest.mark.parametrize("kind", SEQUENCES)
def test_skipped_children_of_a_sequence_are_passed_over(given, kind):
    root, *leaves = given(kind, "-", "S", "-")

    assert "S" == root.tick()
    assert [1, 1, 1] == [leaf.ticks for leaf in leaves]


@pytest.mark.parametrize("kind", FALLBACKS)
def test_skipped_children_of_a_fallback_are_passed_over(given, kind):
    failing, *_ = given(kind, "-", "F", "-")
    succeeding, *_ = given(kind, "-", "S")

    assert "F" == failing.tick()
    assert "S" == succeeding.tick()


@pytest.mark.parametrize("kind", SEQUENCES + FALLBACKS)
def test_a_control_is_skipped_if_all_its_children_are(given, kind):
    root, *_ = given(kind, "-", "-")

    assert "-" == root.tick()


@pytest.mark.parametrize(("kind", "passes", "end"), [(Sequence, "S", "F"), (Fallback, "F", "S")])
def test_it_begins_anew_after_it_has_ended(given, kind, passes, end):
    root, first, _ = given(kind, passes, f"{end}R")

    assert f"{end}R" == root.ticks(0, 1)
    assert 2 == first.ticks


@pytest.mark.parametrize(("kind", "passes"), [(Sequence, "S"), (Fallback, "F")])
def test_it_begins_anew_after_it_was_halted(given, kind, passes):
    root, first, second = given(kind, passes, "R")
    root.tick()
    root.halt()
    root.tick()

    assert (2, 1) == (first.ticks, second.halts)


def test_memory_begins_with_the_failed_child(given):
    root, first, second, third = given(SequenceWithMemory, "S", "FS", "S")

    assert "FS" == root.ticks(0, 1)
    assert (1, 2, 1) == (first.ticks, second.ticks, third.ticks)


def test_memory_lasts_over_a_halt(given):
    root, first, second = given(SequenceWithMemory, "S", "R")
    root.tick()
    root.halt()
    root.tick()

    assert (1, 2, 1) == (first.ticks, second.ticks, second.halts)


def test_memory_ends_with_success(given):
    root, first, second = given(SequenceWithMemory, "S", "S")

    assert "SS" == root.ticks(0, 1)
    assert (2, 2) == (first.ticks, second.ticks)


def test_memory_that_goes_on_with_skipped_children_succeeds(given):
    """A child had succeeded before the failure."""
    root, *_ = given(SequenceWithMemory, "S", "F-")

    assert "FS" == root.ticks(0, 1)


@pytest.mark.parametrize(("kind", "passes"), [(Sequence, "S"), (SequenceWithMemory, "S"), (Fallback, "F")])
def test_what_has_ended_needs_no_look(given, kind, passes):
    root, *_ = given(kind, passes, "R")
    root.tick()

    assert NEVER == root.due()


@pytest.mark.parametrize(("kind", "passes", "end"), [(ReactiveSequence, "S", "F"), (ReactiveFallback, "F", "S")])
def test_a_reactive_control_looks_at_the_controls_before_what_runs(node, tree, told, kind, passes, end):
    begins_again = tree(node(kind, node(Sequence, told(passes)), told("R")))
    begins_again.tick()
    comes_after = tree(node(kind, told("R"), node(Sequence, told(end))))
    comes_after.tick()

    assert 1.0 == begins_again.due()
    assert NEVER == comes_after.due()
