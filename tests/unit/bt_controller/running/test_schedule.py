"""The schedule of ticks: due times, timers and alarms."""

from __future__ import annotations

import math
from functools import partial
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from py_trees.behaviours import Failure, Running, Success
from py_trees.common import ParallelPolicy
from py_trees.composites import Parallel, Selector, Sequence
from py_trees.decorators import EternalGuard, Inverter, Retry, Timeout
from py_trees.timers import Timer

from bt_controller.core.action_leaf import ActionLeaf
from bt_controller.core.robots import Topics
from bt_controller.core.sim_time import simulated_time
from bt_controller.nodes.actions.btcpp import Sleep
from bt_controller.running.schedule import Alarms, TimerQueue, due
from hmrsim.interfaces.nav2_msgs import Wait
from hmrsim_zenoh.client.connection import Condition
from hmrsim_zenoh.errors import RequestError

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
    return Parallel("Both", policy=policy or ParallelPolicy.SuccessOnAll(synchronise=True), children=children)


def sequence(*children, memory=True):
    return Sequence("S", memory=memory, children=children)


def selector(*children, memory=True):
    return Selector("S", memory=memory, children=children)


class Curious(ActionLeaf):
    """A leaf with an update of its own."""

    def update(self):
        return super().update()


AGAIN = ParallelPolicy.SuccessOnAll(synchronise=False)

DUE = {
    "a goal needs no tick": (lambda new: sequence(selector(Inverter("N", new()))), NEVER),
    "a timer is due at its end": (lambda _: Timer("T", 3.5), 13.75),
    "a timeout is due at its end": (lambda new: Timeout("T", new(), 60.0), 70.25),
    "the earliest deadline counts": (lambda new: both(new(), Timer("A", 3.0), Timer("B", 0.5)), 10.75),
    "what is unknown is looked at each period": (lambda _: Running("R"), 12.0),
    "a deadline before the end of the period counts": (lambda new: both(Running("R"), Timer("T", 1.0), new()), 11.25),
    "a leaf with an update of its own is looked at": (lambda new: new(Curious), 12.0),
    "a sequence without memory asks again": (
        lambda new: sequence(Success("C"), new(), memory=False),
        12.0,
    ),
    "a selector without memory asks again": (
        lambda new: selector(Failure("C"), new(), memory=False),
        12.0,
    ),
    "what follows the running child is not looked at": (
        lambda new: sequence(Success("B"), new(), Running("A")),
        NEVER,
    ),
    "a finished child of a synchronised parallel is left alone": (lambda new: both(Success("S"), new()), NEVER),
    "a finished child of another parallel begins again": (
        lambda new: both(Success("S"), new(), policy=AGAIN),
        12.0,
    ),
    "a guard asks a function of the user": (lambda new: EternalGuard("G", new(), condition=lambda: True), 12.0),
    "a retry ticks a failed child again": (lambda _: Retry("R", Failure("F"), num_failures=2), 12.0),
}


@pytest.mark.parametrize(("tree", "expected"), DUE.values(), ids=DUE)
def test_a_tree_is_due(leaf, tree, expected):
    assert expected == due_after_a_tick(tree(leaf))


def test_a_period_that_is_over_is_not_due_again():
    assert due_after_a_tick(Running("R"), now=12.0) == 14.0


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


@pytest.fixture
def timers():
    """Return an timers with three times."""
    timers = TimerQueue()
    for who, time in enumerate((3.0, 1.0, 2.0)):
        timers.put(who, time)
    return timers


def test_the_earliest_comes_first(timers):
    assert (1.0, [1, 2], 3.0) == (timers.earliest, timers.pop_due(2.5), timers.earliest)


def test_an_empty_queue_has_no_time():
    assert (math.inf, []) == (TimerQueue().earliest, TimerQueue().pop_due(1e9))


def test_what_was_put_last_counts(timers):
    timers.put(1, 5.0)
    timers.put(2, math.inf)

    assert ([0], 5.0) == (timers.pop_due(4.0), timers.earliest)


def test_what_was_called_off_and_put_again_comes_once(timers):
    timers.put(1, math.inf)
    timers.put(1, 1.0)

    assert ([1], []) == (timers.pop_due(1.0), timers.pop_due(1.5))


def test_a_time_is_reached_to_the_nanosecond():
    """Deadlines are sums of floats."""
    timers = TimerQueue()
    timers.put(7, 0.1 + 0.2)

    assert [7] == timers.pop_due(0.3)


@given(st.lists(st.tuples(st.integers(0, 4), st.one_of(st.just(math.inf), st.integers(0, 9).map(float)))))
def test_it_is_as_a_table_that_is_searched(puts):
    timers, table = TimerQueue(), {}
    for who, time in puts:
        timers.put(who, time)
        table[who] = time
    earliest = min(table.values(), default=math.inf)
    come = sorted(who for who, time in table.items() if time <= 5.0)

    assert (earliest, come) == (timers.earliest, sorted(timers.pop_due(5.0)))


LOW, FULL = (Condition("wall_e/battery_state", (("/percentage", *when),)) for when in (("<", 0.2), (">=", 0.9)))


class Lockstep:
    """A client in lockstep that records the watched conditions.

    Attributes:
        watched: By condition, what is called when it is met.
        asked: How often something was to be watched.
    """

    over = False

    def __init__(self):
        self.watched = {}
        self.asked = 0

    def watch(self, condition, then):
        self.watched[condition] = then
        self.asked += 1
        return partial(self.watched.pop, condition, None)


@pytest.fixture
def lockstep():
    return Lockstep()


@pytest.fixture
def topics(lockstep):
    return Topics(SimpleNamespace(lockstep=lockstep), asks=True)


@pytest.fixture
def woken():
    return []


@pytest.fixture
def alarms(lockstep, topics, woken):
    return Alarms(lockstep, topics, woken.append)


def test_a_condition_is_watched_until_it_is_not_wanted(alarms, lockstep):
    alarms.set("wall_e", [LOW])
    alarms.set("wall_e", [LOW, FULL])
    alarms.set("wall_e", [FULL])

    assert ([FULL], 2) == ([*lockstep.watched], lockstep.asked)


def test_a_condition_that_is_met_wakes_its_tree(alarms, lockstep, topics, woken):
    alarms.set("wall_e", [LOW])
    lockstep.watched[LOW](None)
    alarms.set("wall_e", [LOW])

    assert (["wall_e"], 2) == (woken, lockstep.asked)
    assert topics.stop_time("wall_e", "battery_state")


def test_after_a_reset_nothing_is_watched(alarms, lockstep):
    alarms.set("wall_e", [LOW])
    alarms.set("eve", [FULL])
    alarms.clear()

    assert {} == lockstep.watched


def test_a_topic_that_can_not_be_watched_is_polled(alarms, lockstep, topics, woken):
    before = topics.stop_time("wall_e", "battery_state")
    alarms.set("wall_e", [LOW])
    lockstep.watched[LOW](RequestError("no"))

    assert (True, False) == (before, topics.stop_time("wall_e", "battery_state"))
    assert ["wall_e"] == woken


def test_when_lockstep_is_over_topics_are_polled(lockstep, topics):
    lockstep.over = True

    assert not topics.stop_time("wall_e", "battery_state")
