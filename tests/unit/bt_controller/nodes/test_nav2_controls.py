"""Nav2's control nodes: what their documentation says, sentence by sentence."""

from __future__ import annotations

from bt_controller.nodes.controls.nav2 import (
    NonblockingSequence,
    PersistentSequence,
    PipelineSequence,
    RecoveryNode,
    RoundRobin,
)
from tests.unit.bt_controller.nodes.conftest import NEVER, Row, rows

WRAPS = {"wrap_around": "true"}
INDEX = {"current_child_idx": "{index}"}


def retries(number):
    return {"number_of_retries": str(number)}


@rows(
    {
        "the second child has nothing to do while the first succeeds": Row(RecoveryNode, "S S", "S", ticks="1 0"),
        "the first child is tried again after a recovery": Row(RecoveryNode, "FS S", "S", retries(1), ticks="2 1"),
        "it fails when all retries are used up": Row(RecoveryNode, "F S", "F", retries(6), ticks="7 6"),
        "it fails when the recovery does": Row(RecoveryNode, "F F", "F", retries(6), ticks="1 1"),
        "a recovery that is skipped is none": Row(RecoveryNode, "F -", "F", retries(6)),
        "it is skipped when its first child is": Row(RecoveryNode, "- S", "-"),
        "either child may take its time": Row(RecoveryNode, "RFRS RS", "RRRS", begun="2 1"),
        "retries are counted anew after a halt": Row(RecoveryNode, "FRFRS S", "R!RS", retries(1)),
        "a halt halts the child that runs": Row(RecoveryNode, "F R", "R!", halts="0 1"),
        "goals that fail at once must not keep time from going on": Row(
            RecoveryNode, "F S", "R", retries(1500), ticks="1000 1000", due=1.0
        ),
        "the next try comes a period later": Row(RecoveryNode, "F S", "RF", retries(1500), ticks="1501 1500"),
        "it waits for the child that runs": Row(RecoveryNode, "R S", "R", due=NEVER),
    }
)
def test_recovery_node(behaves, row):
    behaves(row)


@rows(
    {
        "a child that runs for the first time keeps the next ones": Row(PipelineSequence, "RRS R", "RR", ticks="2 0"),
        "children before the one that runs are ticked again": Row(PipelineSequence, "S R", "RRR", ticks="3 3"),
        "a child that runs again keeps the reached ones ticked": Row(
            PipelineSequence, "SRRS RRS R", "RRR", ticks="3 3 1"
        ),
        "it succeeds when its last child does": Row(PipelineSequence, "SR RS", "RS", halts="1 0"),
        "it fails when any child does and halts the others": Row(PipelineSequence, "SF R", "RF", halts="0 1"),
        "it forgets how far it came when it begins again": Row(PipelineSequence, "SR R", "R!R", ticks="2 1"),
        "it passes over skipped children": Row(PipelineSequence, "- S", "S"),
        "it is skipped if all its children are": Row(PipelineSequence, "- -", "-"),
    }
)
def test_pipeline_sequence(behaves, row):
    behaves(row)


@rows(
    {
        "the next time it goes on after the child that has succeeded": Row(RoundRobin, "S S S", "S!S", ticks="1 1 0"),
        "a child that fails is followed by the next one in the same tick": Row(RoundRobin, "F S S", "S", ticks="1 1 0"),
        "it fails when all children have": Row(RoundRobin, "FS F", "FS", ticks="2 1"),
        "it waits for a child that runs": Row(RoundRobin, "RS S", "RS", ticks="2 0"),
        "after the last child it fails once instead of wrapping around": Row(RoundRobin, "S S", "SSFS", ticks="2 1"),
        "with wrap_around the first child comes after the last": Row(RoundRobin, "S S", "SSSS", WRAPS, ticks="2 2"),
        "with wrap_around it fails when all have failed in a row": Row(RoundRobin, "SF F", "SF", WRAPS),
        "halted it begins with the first child": Row(RoundRobin, "S R", "SR!S", ticks="2 1"),
        "all skipped is skipped": Row(RoundRobin, "- -", "-"),
        "a failure among skipped children is one": Row(RoundRobin, "- F", "F"),
    }
)
def test_round_robin(behaves, row):
    behaves(row)


@rows(
    {
        "a child that runs does not keep the next ones": Row(NonblockingSequence, "R S R", "RR", ticks="2 2 2"),
        "it succeeds when all have in one tick": Row(NonblockingSequence, "RS S", "RS"),
        "a failure halts the others": Row(NonblockingSequence, "R F S", "F", ticks="1 1 0", halts="1 0 0"),
        "all skipped is skipped": Row(NonblockingSequence, "-", "-"),
        "it passes over skipped children": Row(NonblockingSequence, "- S", "S"),
    }
)
def test_nonblocking_sequence(behaves, row):
    behaves(row)


@rows(
    {
        "it begins with the child that the index says": Row(
            PersistentSequence, "S S R", "R", INDEX, before={"index": 1}, ticks="0 1 1", after={"index": 2}
        ),
        "it goes on where it was when it was halted": Row(
            PersistentSequence, "S R", "R!R", INDEX, before={"index": 0}, ticks="1 2"
        ),
        "after a failure the index is zero": Row(
            PersistentSequence, "S F", "F", INDEX, before={"index": 0}, after={"index": 0}
        ),
        "after all children the index is zero": Row(
            PersistentSequence, "S -", "S", INDEX, before={"index": 0}, after={"index": 0}
        ),
    }
)
def test_persistent_sequence(behaves, row):
    behaves(row)
