"""Sleep, Delay and Timeout, by BehaviorTree.CPP's documentation, in simulated time."""

from __future__ import annotations

import pytest

from bt_controller.core.node import PortError
from bt_controller.nodes.actions.btcpp import Sleep
from bt_controller.nodes.controls.sequences import ReactiveSequence
from bt_controller.nodes.decorators.gates import Delay, Timeout

NEVER = float("inf")


def test_sleep_runs_for_a_time(node, tree):
    root = tree(node(Sleep, msec="1500"))

    assert "RRS" == root.ticks(10.0, 11.4, 11.5)


def test_sleep_needs_no_look_before_its_end(node, tree):
    root = tree(node(Sleep, msec="1500"))
    root.tick(10.25)

    assert 11.75 == root.due()


def test_sleep_that_has_ended_is_looked_at_where_it_is_ticked_again(node, tree, told):
    root = tree(node(ReactiveSequence, node(Sleep, msec="0"), told("R")))
    root.tick(10.25)

    assert 11.0 == root.due()


def test_sleep_begins_anew_after_a_halt(node, tree):
    root = tree(node(Sleep, msec="1000"))
    root.tick(10.0)
    root.halt()

    assert "RRS" == root.ticks(10.5, 11.0, 11.5)


def test_no_sleep_succeeds_at_once(node, tree):
    assert "S" == tree(node(Sleep, msec="0")).tick(3.0)


def test_a_malformed_number_is_an_error(node, tree):
    with pytest.raises(PortError, match="port 'msec': 'soon' is not a whole number"):
        tree(node(Sleep, msec="soon"))


def test_delay_ticks_its_child_after_a_time(node, tree, told):
    leaf = told("RF")
    root = tree(node(Delay, leaf, delay_msec="2000"))

    assert "RR" == root.ticks(5.0, 6.9)
    assert 0 == leaf.ticks
    assert "RF" == root.ticks(7.0, 7.1)


def test_delay_needs_no_look_before_its_end(node, tree, told):
    root = tree(node(Delay, told("R"), delay_msec="2000"))
    root.tick(5.25)
    before = root.due()
    root.tick(7.25)

    assert (7.25, NEVER) == (before, root.due())


def test_delay_begins_anew(node, tree, told):
    root = tree(node(Delay, told("S"), delay_msec="1000"))

    assert "RSR" == root.ticks(0.0, 1.0, 1.5)
    root.halt()
    assert "RS" == root.ticks(2.0, 3.0)


def test_timeout_ends_as_its_child_does(node, tree, told):
    root = tree(node(Timeout, told("RS"), msec="1000"))

    assert "RS" == root.ticks(4.0, 4.9)


def test_timeout_halts_a_child_that_takes_too_long(node, tree, told):
    leaf = told("R")
    root = tree(node(Timeout, leaf, msec="1000"))

    assert "RRF" == root.ticks(4.0, 4.9, 5.0)
    assert 1 == leaf.halts


def test_timeout_takes_an_end_at_the_last_moment(node, tree, told):
    """An action that ends at the same instant does not time out."""
    root = tree(node(Timeout, told("RS"), msec="1000"))

    assert "RS" == root.ticks(4.0, 5.0)


def test_timeout_is_due_when_the_time_is_over(node, tree, told):
    root = tree(node(Timeout, told("R"), msec="60000"))
    root.tick(10.25)

    assert 70.25 == root.due()


def test_timeout_of_zero_is_none(node, tree, told):
    root = tree(node(Timeout, told("R"), msec="0"))

    assert "RR" == root.ticks(0.0, 1e6)
    assert NEVER == root.due()


def test_timeout_begins_anew(node, tree, told):
    root = tree(node(Timeout, told("R"), msec="1000"))

    assert "RFRRF" == root.ticks(0.0, 1.0, 1.5, 2.4, 2.5)


@pytest.mark.parametrize(("kind", "port"), [(Delay, "delay_msec"), (Timeout, "msec")])
def test_they_are_skipped_with_their_child(node, tree, told, kind, port):
    assert "-" == tree(node(kind, told("-"), **{port: "0"})).tick()
