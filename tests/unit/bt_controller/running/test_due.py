"""When a tree has to be ticked although nothing has happened to its goals."""

from __future__ import annotations

import math

import pytest
from py_trees.behaviours import Failure, Running, Success
from py_trees.common import ParallelPolicy
from py_trees.composites import Parallel, Selector, Sequence
from py_trees.decorators import EternalGuard, Inverter, Retry, Timeout
from py_trees.timers import Timer

from bt_controller.core.action_leaf import ActionLeaf
from bt_controller.core.sim_time import simulated_time
from bt_controller.nodes.actions.btcpp import Sleep
from bt_controller.running.schedule import due
from hmrsim.interfaces.nav2_msgs import Wait

NEVER = math.inf


@pytest.fixture
def leaf(client):
    """Return what makes leaves that wait for their goals."""

    def make(kind=ActionLeaf):
        leaf = kind("Wait", "wait", Wait.Goal())
        leaf.setup(client=client, robot="wall_e")
        return leaf

    return make


def due_after_a_tick(root, now=10.25):
    """Tick a tree, and return when it is due, with periods of 2 s."""
    with simulated_time(now):
        root.tick_once()
    return due(root, now, 2.0).time


def both(*children, policy=None):
    """Return a parallel."""
    return Parallel("Both", policy=policy or ParallelPolicy.SuccessOnAll(synchronise=True), children=children)


def test_a_goal_needs_no_tick(leaf):
    """A goal announces its end, also deep in a tree."""
    root = Sequence("S", memory=True, children=[Selector("F", memory=True, children=[Inverter("N", leaf())])])

    assert due_after_a_tick(root) == NEVER


def test_a_timer_is_due_at_its_end():
    """The next period does not matter."""
    assert due_after_a_tick(Timer("T", 3.5)) == 13.75


def test_a_timeout_is_due_at_its_end(leaf):
    """Its child may end before."""
    assert due_after_a_tick(Timeout("T", leaf(), 60.0)) == 70.25


def test_the_earliest_deadline_counts(leaf):
    """Of all that runs side by side."""
    assert due_after_a_tick(both(leaf(), Timer("A", 3.0), Timer("B", 0.5))) == 10.75


def test_what_is_unknown_is_looked_at_each_period():
    """Periods count from zero, so that all trees are ticked at the same instants."""
    assert due_after_a_tick(Running("R")) == 12.0


def test_a_period_that_is_over_is_not_due_again():
    """At the end of a period the next is waited for."""
    assert due_after_a_tick(Running("R"), now=12.0) == 14.0


def test_a_deadline_before_the_end_of_the_period_counts(leaf):
    """Whatever else is looked at."""
    assert due_after_a_tick(both(Running("R"), Timer("T", 1.0), leaf())) == 11.25


def test_a_leaf_of_the_users_with_an_update_of_its_own_is_looked_at(leaf):
    """Its update may depend on anything."""

    class Curious(ActionLeaf):
        def update(self):
            return super().update()

    assert due_after_a_tick(leaf(Curious)) == 12.0


def test_a_condition_of_a_tree_without_memory_is_looked_at(leaf):
    """Each tick asks it again, so that there have to be ticks."""
    assert due_after_a_tick(Sequence("S", memory=False, children=[Success("C"), leaf()])) == 12.0
    assert due_after_a_tick(Selector("S", memory=False, children=[Failure("C"), leaf()])) == 12.0


def test_what_comes_after_the_running_child_is_not_looked_at(leaf):
    """Nor what came before it, where there is memory."""
    children = [Success("Before"), leaf(), Running("After")]

    assert due_after_a_tick(Sequence("S", memory=True, children=children)) == NEVER


def test_a_finished_child_of_a_synchronised_parallel_is_left_alone(leaf):
    """Without synchronisation it would be ticked again."""
    again = ParallelPolicy.SuccessOnAll(synchronise=False)

    assert due_after_a_tick(both(Success("S"), leaf())) == NEVER
    assert due_after_a_tick(both(Success("S"), leaf(), policy=again)) == 12.0


def test_a_guard_is_looked_at(leaf):
    """It asks a function of the user's."""
    assert due_after_a_tick(EternalGuard("G", leaf(), condition=lambda: True)) == 12.0


def test_a_retry_is_not_waited_for_in_vain():
    """Its child has failed, and is to be ticked again."""
    assert due_after_a_tick(Retry("R", Failure("F"), num_failures=2)) == 12.0


def test_a_deadline_of_a_former_time_is_looked_at():
    """The simulation was reset to an earlier time, or the deadline has passed in vain: the runner must not spin."""
    timer = Timer("T", 1.0)
    due_after_a_tick(timer)

    assert due(timer, 11.25, 2.0).time == 12.0


def test_no_timer_is_due_again_at_once():
    """A deadline that comes within this nanosecond, and was not taken for reached, is looked at a period later."""
    timer = Timer("Timer", 1.0)
    with simulated_time(10.25):
        timer.tick_once()
    timer.finish_time = 10.25 + 0.4e-9

    assert 12.0 == due(timer, 10.25, 2.0).time


def test_a_node_of_an_xml_tree_that_starts_again_is_polled():
    """At the next period, as is not known when it ends."""
    assert 12.0 == due(Sleep("sleep"), 10.25, 2.0).time
