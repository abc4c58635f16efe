"""Conditions for which time stops, by tree."""

from __future__ import annotations

from functools import partial
from types import SimpleNamespace

import pytest

from bt_controller.core.robots import Topics
from bt_controller.running.schedule import Alarms
from hmrsim_zenoh.client.conditions import Condition
from hmrsim_zenoh.errors import RequestError

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
        """Record a condition to watch."""
        self.watched[condition] = then
        self.asked += 1
        return partial(self.watched.pop, condition, None)


@pytest.fixture
def lockstep():
    """Return it without a condition."""
    return Lockstep()


@pytest.fixture
def topics(lockstep):
    """Return the topics of a client in lockstep."""
    return Topics(SimpleNamespace(lockstep=lockstep), asks=True)


@pytest.fixture
def woken():
    """Return the trees that were woken."""
    return []


@pytest.fixture
def alarms(lockstep, topics, woken):
    """Return alarms without a condition."""
    return Alarms(lockstep, topics, woken.append)


def test_a_condition_is_watched_until_it_is_not_wanted(alarms, lockstep):
    """The simulator gets it once, no matter how often the tree is ticked meanwhile."""
    alarms.set("wall_e", [LOW])
    alarms.set("wall_e", [LOW, FULL])
    alarms.set("wall_e", [FULL])

    assert ([FULL], 2) == ([*lockstep.watched], lockstep.asked)


def test_a_condition_that_is_met_wakes_its_tree(alarms, lockstep, woken):
    """And is watched again if the tree still wants it."""
    alarms.set("wall_e", [LOW])
    lockstep.watched[LOW](None)
    alarms.set("wall_e", [LOW])

    assert (["wall_e"], 2) == (woken, lockstep.asked)


def test_after_a_reset_nothing_is_watched(alarms, lockstep):
    """Until trees are ticked again."""
    alarms.set("wall_e", [LOW])
    alarms.set("eve", [FULL])
    alarms.clear()

    assert {} == lockstep.watched


def test_a_topic_that_can_not_be_watched_is_polled(alarms, lockstep, topics, woken):
    """Its tree is woken to learn of it."""
    before = topics.stop_time("wall_e", "battery_state")
    alarms.set("wall_e", [LOW])
    lockstep.watched[LOW](RequestError("no"))

    assert (True, False) == (before, topics.stop_time("wall_e", "battery_state"))
    assert ["wall_e"] == woken


def test_when_lockstep_is_over_topics_are_polled(lockstep, topics):
    """Time goes by itself then, and stops for nothing."""
    lockstep.over = True

    assert not topics.stop_time("wall_e", "battery_state")
