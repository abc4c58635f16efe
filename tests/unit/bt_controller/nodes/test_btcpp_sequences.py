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
from tests.unit.bt_controller.nodes.conftest import NEVER, Row, rows

SEQUENCES = [Sequence, AsyncSequence, SequenceWithMemory, ReactiveSequence]
FALLBACKS = [Fallback, AsyncFallback, ReactiveFallback]
MEMORY = SequenceWithMemory


@rows(
    {
        "a sequence succeeds when all children have": Row(SEQUENCES, "S S S", "S", ticks="1 1 1"),
        "a sequence fails with the first child that does": Row(SEQUENCES, "S F S", "F", ticks="1 1 0"),
        "a sequence passes over skipped children": Row(SEQUENCES, "- S -", "S", ticks="1 1 1"),
        "a fallback fails when all children have": Row(FALLBACKS, "F F F", "F", ticks="1 1 1"),
        "a fallback succeeds with the first child that does": Row(FALLBACKS, "F S S", "S", ticks="1 1 0"),
        "a fallback passes over skipped children": Row(FALLBACKS, "- F -", "F"),
        "a fallback succeeds after a skipped child": Row(FALLBACKS, "- S", "S"),
        "either is skipped if all its children are": Row(SEQUENCES + FALLBACKS, "- -", "-"),
        "a sequence continues with its running child": Row([Sequence, MEMORY], "S RS", "RS", ticks="1 2"),
        "a fallback continues with its running child": Row(Fallback, "F RF", "RF", ticks="1 2"),
        "a running child needs no look in a sequence": Row([Sequence, MEMORY], "S R", "R", due=NEVER),
        "a running child needs no look in a fallback": Row(Fallback, "F R", "R", due=NEVER),
        "a reactive sequence ticks again what comes before a running child": Row(
            ReactiveSequence, "S RS", "RS", ticks="2 2", begun="2 1"
        ),
        "a reactive fallback ticks again what comes before a running child": Row(
            ReactiveFallback, "F RF", "RF", ticks="2 2", begun="2 1"
        ),
        "a condition that has become false stops what runs": Row(
            ReactiveSequence, "SF R", "RF", ticks="2 1", halts="0 1"
        ),
        "a condition that has become true stops what runs": Row(
            ReactiveFallback, "FS R", "RS", ticks="2 1", halts="0 1"
        ),
        "one child runs at most in a reactive sequence": Row(ReactiveSequence, "SR R", "RR", halts="0 1"),
        "one child runs at most in a reactive fallback": Row(ReactiveFallback, "FR R", "RR", halts="0 1"),
        "a sequence begins anew after it has ended": Row(Sequence, "S FR", "FR", ticks="2 2"),
        "a fallback begins anew after it has ended": Row(Fallback, "F SR", "SR", ticks="2 2"),
        "a sequence begins anew after a halt": Row(Sequence, "S R", "R!R", ticks="2 2", halts="0 1"),
        "a fallback begins anew after a halt": Row(Fallback, "F R", "R!R", ticks="2 2", halts="0 1"),
        "memory begins with the failed child": Row(MEMORY, "S FS S", "FS", ticks="1 2 1"),
        "memory lasts over a halt": Row(MEMORY, "S R", "R!R", ticks="1 2", halts="0 1"),
        "memory ends with success": Row(MEMORY, "S S", "SS", ticks="2 2"),
        "memory counts a success before a failure though the rest is skipped": Row(MEMORY, "S F-", "FS"),
    }
)
def test_sequences_and_fallbacks(behaves, row):
    behaves(row)


@pytest.mark.parametrize(("kind", "passes", "end"), [(ReactiveSequence, "S", "F"), (ReactiveFallback, "F", "S")])
def test_a_reactive_control_looks_at_the_controls_before_what_runs(node, tree, told, kind, passes, end):
    begins_again = tree(node(kind, node(Sequence, told(passes)), told("R")))
    begins_again.tick()
    comes_after = tree(node(kind, told("R"), node(Sequence, told(end))))
    comes_after.tick()

    assert (1.0, NEVER) == (begins_again.due(), comes_after.due())
