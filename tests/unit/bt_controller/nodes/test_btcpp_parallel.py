"""Parallel and ParallelAll, sentence by sentence of BehaviorTree.CPP's documentation."""

from __future__ import annotations

import pytest

from bt_controller.core.node import PortError
from bt_controller.nodes.controls.sequences import Parallel, ParallelAll, Sequence
from tests.unit.bt_controller.nodes.conftest import NEVER, Row, rows

BOTH = [Parallel, ParallelAll]


@rows(
    {
        "by default all children have to succeed": Row(Parallel, "S RS RRS", "RRS", ticks="1 2 3"),
        "by default one failure is enough": Row(Parallel, "R RF R", "RF", halts="1 0 1"),
        "it succeeds when so many have": Row(
            Parallel, "R RS S R", "RS", {"success_count": "2"}, ticks="2 2 1 1", halts="1 0 0 1"
        ),
        "it fails when so many have": Row(Parallel, "F RF R", "RF", {"success_count": "1", "failure_count": "2"}),
        "minus 2 successes are all but one": Row(Parallel, "S S R", "S", {"success_count": "-2"}),
        "minus 1 failures are all": Row(Parallel, "F F RF", "RF", {"success_count": "1", "failure_count": "-1"}),
        "minus 1 failures may come in one tick": Row(
            Parallel, "F F F", "F", {"success_count": "1", "failure_count": "-1"}
        ),
        "it fails when it can't succeed any more": Row(
            Parallel, "F R R", "F", {"success_count": "3", "failure_count": "2"}
        ),
        "skipped children count beside a negative number": Row(Parallel, "S -", "S", {"success_count": "-1"}),
        "skipped children do not count beside another number": Row(Parallel, "S -", "R", {"success_count": "2"}),
        "skipped children are ticked again, as they may have something to do": Row(
            Parallel, "S -S", "RS", {"success_count": "2"}, ticks="1 2"
        ),
        "either is skipped if all children are": Row(BOTH, "- -", "-"),
        "a halt halts what runs": Row(BOTH, "S R", "R!R", ticks="2 2", halts="0 1"),
        "all waits for all": Row(ParallelAll, "F RRS S", "RRF", ticks="1 3 1"),
        "all succeeds with fewer failures than its port says": Row(ParallelAll, "F S S", "S", {"max_failures": "2"}),
        "all fails with as many failures as its port says": Row(ParallelAll, "F F S", "F", {"max_failures": "2"}),
        "all succeeds unless all fail if its port is minus 1": Row(ParallelAll, "F F S", "S", {"max_failures": "-1"}),
        "all does not wait for skipped children": Row(ParallelAll, "- RS", "RS"),
    }
)
def test_parallels(behaves, row):
    behaves(row)


@pytest.mark.parametrize(
    ("kind", "port"), [(Parallel, "success_count"), (Parallel, "failure_count"), (ParallelAll, "max_failures")]
)
def test_more_than_there_are_is_an_error(node, tree, told, kind, port):
    root = tree(node(kind, told("S"), told("S"), **{port: "3"}))

    with pytest.raises(PortError, match=rf"port '{port}': 3 of 2 children is never reached"):
        root.tick()


@pytest.mark.parametrize("kind", BOTH)
def test_what_has_not_ended_is_looked_at(node, tree, told, kind):
    ended = tree(node(kind, node(Sequence, told("S")), told("R")))
    ended.tick()
    skipped = tree(node(kind, node(Sequence, told("-")), told("R")))
    skipped.tick()

    assert (NEVER, 1.0) == (ended.due(), skipped.due())


@pytest.mark.parametrize("kind", BOTH)
def test_what_is_idle_begins_with_itself(node, told, kind):
    assert [] == node(kind, told("R")).next_ticked()
