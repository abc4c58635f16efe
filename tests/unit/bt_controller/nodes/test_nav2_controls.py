"""Nav2's control nodes: what their documentation says, sentence by sentence."""

from __future__ import annotations

import math

from py_trees.common import Status

from bt_controller.nodes.controls.nav2 import (
    NonblockingSequence,
    PersistentSequence,
    PipelineSequence,
    RecoveryNode,
    RoundRobin,
)


class TestRecoveryNode:
    """RecoveryNode ticks a recovery after a failure, and then its first child again."""

    def test_the_second_child_has_nothing_to_do_while_the_first_succeeds(self, node, told, tree):
        first, second = told("S"), told("S")

        assert "S" == tree(node(RecoveryNode, first, second)).tick()
        assert (1, 0) == (first.ticks, second.ticks)

    def test_the_first_child_is_tried_again_after_a_recovery(self, node, told, tree):
        first, second = told("FS"), told("S")

        assert "S" == tree(node(RecoveryNode, first, second, number_of_retries="1")).tick()
        assert (2, 1) == (first.ticks, second.ticks)

    def test_it_fails_when_all_retries_are_used_up(self, node, told, tree):
        """Six retries are seven attempts and six recoveries."""
        first, second = told("F"), told("S")

        assert "F" == tree(node(RecoveryNode, first, second, number_of_retries="6")).tick()
        assert (7, 6) == (first.ticks, second.ticks)

    def test_it_fails_when_the_recovery_does(self, node, told, tree):
        first, second = told("F"), told("F")

        assert "F" == tree(node(RecoveryNode, first, second, number_of_retries="6")).tick()
        assert (1, 1) == (first.ticks, second.ticks)

    def test_a_recovery_that_is_skipped_is_none(self, node, told, tree):
        assert "F" == tree(node(RecoveryNode, told("F"), told("-"), number_of_retries="6")).tick()

    def test_it_is_skipped_when_its_first_child_is(self, node, told, tree):
        assert "-" == tree(node(RecoveryNode, told("-"), told("S"))).tick()

    def test_either_child_may_take_its_time(self, node, told, tree):
        first, second = told("RFRS"), told("RS")

        assert "RRRS" == tree(node(RecoveryNode, first, second)).ticks(0, 1, 2, 3)
        assert (2, 1) == (first.begun, second.begun)

    def test_retries_are_counted_anew_when_it_was_halted(self, node, told, tree):
        first = told("FRFRS")
        ticked = tree(node(RecoveryNode, first, told("S"), number_of_retries="1"))
        ticked.tick()
        ticked.halt()

        assert "RS" == ticked.ticks(1, 2)

    def test_a_halt_halts_the_child_that_runs(self, node, told, tree):
        first, second = told("F"), told("R")
        ticked = tree(node(RecoveryNode, first, second))
        ticked.tick()
        ticked.halt()

        assert (0, 1) == (first.halts, second.halts)

    def test_a_thousand_tries_are_enough_for_one_instant(self, node, told, tree):
        """Goals that fail at once must not keep time from going on; the next try comes a period later."""
        first = told("F")
        ticked = tree(node(RecoveryNode, first, told("S"), number_of_retries="1500"))
        status, due, tries = ticked.tick(), ticked.due(), first.ticks

        assert ("R", 1.0, 1000) == (status, due, tries)
        assert ("F", 1501) == (ticked.tick(1), first.ticks)

    def test_it_waits_for_the_child_that_runs(self, node, told, tree):
        ticked = tree(node(RecoveryNode, told("R"), told("S")))
        ticked.tick()

        assert math.inf == ticked.due()


class TestPipelineSequence:
    """The table of Nav2's documentation: A runs, then B, then both."""

    def test_a_child_that_runs_for_the_first_time_keeps_the_next_ones(self, node, told, tree):
        a, b = told("RRS"), told("R")
        ticked = tree(node(PipelineSequence, a, b))

        assert "RR" == ticked.ticks(0, 1)
        assert 0 == b.ticks

    def test_children_before_the_one_that_runs_are_ticked_again(self, node, told, tree):
        a, b = told("S"), told("R")
        tree(node(PipelineSequence, a, b)).ticks(0, 1, 2)

        assert (3, 3) == (a.ticks, b.ticks)

    def test_a_child_that_runs_again_keeps_the_reached_ones_ticked(self, node, told, tree):
        a, b, c = told("SRRS"), told("RRS"), told("R")
        ticked = tree(node(PipelineSequence, a, b, c))

        assert "RRR" == ticked.ticks(0, 1, 2)
        assert (3, 3, 1) == (a.ticks, b.ticks, c.ticks)

    def test_it_succeeds_when_its_last_child_does(self, node, told, tree):
        a, b = told("SR"), told("RS")
        ticked = tree(node(PipelineSequence, a, b))

        assert "RS" == ticked.ticks(0, 1)
        assert 1 == a.halts

    def test_it_fails_when_any_child_does_and_halts_the_others(self, node, told, tree):
        a, b = told("SF"), told("R")
        ticked = tree(node(PipelineSequence, a, b))

        assert "RF" == ticked.ticks(0, 1)
        assert 1 == b.halts

    def test_it_forgets_how_far_it_came_when_it_begins_again(self, node, told, tree):
        a, b = told("SR"), told("R")
        ticked = tree(node(PipelineSequence, a, b))
        ticked.tick()
        ticked.halt()
        ticked.tick(1)

        assert (2, 1) == (a.ticks, b.ticks)

    def test_skipped_children_are_as_if_they_were_not_there(self, node, told, tree):
        assert "S" == tree(node(PipelineSequence, told("-"), told("S"))).tick()
        assert "-" == tree(node(PipelineSequence, told("-"), told("-"))).tick()


class TestRoundRobin:
    """RoundRobin ticks another child each time."""

    def test_the_next_time_it_goes_on_after_the_child_that_has_succeeded(self, node, told, tree):
        children = [told("S"), told("S"), told("S")]
        ticked = tree(node(RoundRobin, *children))
        ticked.tick()
        ticked.root.stop(Status.INVALID)
        ticked.tick(1)

        assert [1, 1, 0] == [child.ticks for child in children]

    def test_a_child_that_fails_is_followed_by_the_next_one_in_the_same_tick(self, node, told, tree):
        children = [told("F"), told("S"), told("S")]

        assert "S" == tree(node(RoundRobin, *children)).tick()
        assert [1, 1, 0] == [child.ticks for child in children]

    def test_it_fails_when_all_children_have(self, node, told, tree):
        children = [told("FS"), told("F")]
        ticked = tree(node(RoundRobin, *children))

        assert "FS" == ticked.ticks(0, 1)
        assert [2, 1] == [child.ticks for child in children]

    def test_it_waits_for_a_child_that_runs(self, node, told, tree):
        children = [told("RS"), told("S")]

        assert "RS" == tree(node(RoundRobin, *children)).ticks(0, 1)
        assert [2, 0] == [child.ticks for child in children]

    def test_after_the_last_child_it_fails_once_instead_of_wrapping_around(self, node, told, tree):
        children = [told("S"), told("S")]
        ticked = tree(node(RoundRobin, *children))

        assert "SSFS" == ticked.ticks(0, 1, 2, 3)
        assert [2, 1] == [child.ticks for child in children]

    def test_with_wrap_around_the_first_child_comes_after_the_last(self, node, told, tree):
        children = [told("S"), told("S")]
        ticked = tree(node(RoundRobin, *children, wrap_around="true"))

        assert "SSSS" == ticked.ticks(0, 1, 2, 3)
        assert [2, 2] == [child.ticks for child in children]

    def test_with_wrap_around_it_fails_when_all_have_failed_in_a_row(self, node, told, tree):
        children = [told("SF"), told("F")]
        ticked = tree(node(RoundRobin, *children, wrap_around="true"))

        assert "SF" == ticked.ticks(0, 1)

    def test_halted_it_begins_with_the_first_child(self, node, told, tree):
        children = [told("S"), told("R")]
        ticked = tree(node(RoundRobin, *children))
        ticked.ticks(0, 1)
        ticked.halt()
        ticked.tick(2)

        assert [2, 1] == [child.ticks for child in children]

    def test_all_skipped_is_skipped(self, node, told, tree):
        assert "-" == tree(node(RoundRobin, told("-"), told("-"))).tick()
        assert "F" == tree(node(RoundRobin, told("-"), told("F"))).tick()


class TestNonblockingSequence:
    """NonblockingSequence ticks all its children each time."""

    def test_a_child_that_runs_does_not_keep_the_next_ones(self, node, told, tree):
        children = [told("R"), told("S"), told("R")]

        assert "RR" == tree(node(NonblockingSequence, *children)).ticks(0, 1)
        assert [2, 2, 2] == [child.ticks for child in children]

    def test_it_succeeds_when_all_have_in_one_tick(self, node, told, tree):
        assert "RS" == tree(node(NonblockingSequence, told("RS"), told("S"))).ticks(0, 1)

    def test_a_failure_halts_the_others(self, node, told, tree):
        first, last = told("R"), told("S")
        ticked = tree(node(NonblockingSequence, first, told("F"), last))

        assert "F" == ticked.tick()
        assert (1, 0) == (first.halts, last.ticks)

    def test_all_skipped_is_skipped(self, node, told, tree):
        assert "-" == tree(node(NonblockingSequence, told("-"))).tick()
        assert "S" == tree(node(NonblockingSequence, told("-"), told("S"))).tick()


class TestPersistentSequence:
    """The index is on the blackboard."""

    def test_it_begins_with_the_child_that_the_index_says(self, node, told, tree, board):
        board["/index"] = 1
        children = [told("S"), told("S"), told("R")]
        tree(node(PersistentSequence, *children, current_child_idx="{index}")).tick()

        assert [0, 1, 1] == [child.ticks for child in children]
        assert 2 == board["/index"]

    def test_it_goes_on_where_it_was_when_it_was_halted(self, node, told, tree, board):
        board["/index"] = 0
        children = [told("S"), told("R")]
        ticked = tree(node(PersistentSequence, *children, current_child_idx="{index}"))
        ticked.tick()
        ticked.halt()
        ticked.tick(1)

        assert [1, 2] == [child.ticks for child in children]

    def test_after_a_failure_the_index_is_zero(self, node, told, tree, board):
        board["/index"] = 0
        ticked = tree(node(PersistentSequence, told("S"), told("F"), current_child_idx="{index}"))

        assert "F" == ticked.tick()
        assert 0 == board["/index"]

    def test_after_all_children_the_index_is_zero(self, node, told, tree, board):
        board["/index"] = 0
        ticked = tree(node(PersistentSequence, told("S"), told("-"), current_child_idx="{index}"))

        assert "S" == ticked.tick()
        assert 0 == board["/index"]
