"""Timers of py_trees and of XML trees' nodes: the same in real time and in lockstep, in between, and after a reset."""

from __future__ import annotations

import json

import pytest
from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy, Status
from py_trees.composites import Parallel, Sequence
from py_trees.timers import Timer

from bt_controller.core.node import Leaf
from bt_controller.core.sim_time import now, reached
from bt_controller.loading.trees import Plan
from bt_controller.running.clocks import Mailbox, clock_for
from bt_controller.running.mission import missions_for
from bt_controller.running.runner import Runner
from hmrsim_zenoh.client.client import Client
from tests.served_world import served_world

FAST = 200
"""Real-time factor: a second of the wall's is not taken for one of the simulator's."""
LATE = 2000.0
"""Simulated seconds by which a tick may be late there on a busy machine: ten of the wall's."""


class Alarm(Leaf):
    """Succeeds some seconds after it began, and says when it wants to be looked at."""

    def __init__(self, seconds):
        super().__init__(f"Alarm {seconds}")
        self._seconds = seconds

    def initialise(self):
        """Set it."""
        self._deadline = now() + self._seconds

    def update(self):
        """Look whether it rings."""
        return Status.SUCCESS if reached(self._deadline) else Status.RUNNING

    def next_tick_time(self):
        """Return when it rings."""
        return self._deadline


class Asks(Behaviour):
    """Asks a service of the simulator, once."""

    def __init__(self, service, **request):
        super().__init__(service)
        self._asked = service, json.dumps(request).encode()

    def setup(self, **kwargs):
        """Remember the client."""
        self._client = kwargs["client"]

    def update(self):
        """Ask."""
        service, payload = self._asked
        self._client.get(self._client.keys.world(service), payload=payload)
        return Status.SUCCESS


def ticks(make, **settings):
    """Return the simulated times at which a robot's tree was ticked."""
    found, mailbox = [], Mailbox()
    with served_world(**settings) as options, Client(options, name="trees") as client:
        plan = Plan("test", make, takes_robot=False, confirmed=False)
        clock = clock_for(client, mailbox, feedback=False, grace=5.0)
        missions = missions_for(["wall_e"], plan)
        runner = Runner(client, missions, clock, mailbox, show=lambda _mission, time: found.append(time))
        outcome = runner.run()
    if not outcome.succeeded:
        raise AssertionError(outcome)
    return found


def steps(*children):
    """Return some steps, one after the other."""
    return Sequence("Steps", memory=True, children=list(children))


def beside(timer, *children):
    """Return a timer, and steps that are done meanwhile."""
    return Parallel("Both", policy=ParallelPolicy.SuccessOnAll(synchronise=True), children=[timer, steps(*children)])


@pytest.mark.parametrize("timer", [Timer, Alarm], ids=["py_trees", "node"])
class TestTimers:
    """Both kinds."""

    @staticmethod
    def make(kind, seconds):
        """Return a timer."""
        return Timer(f"Timer {seconds}", seconds) if kind is Timer else Alarm(seconds)

    def test_in_lockstep_it_ends_at_its_time(self, timer):
        """Nothing is polled, and nothing is late."""
        found = ticks(lambda: steps(self.make(timer, 2.5), self.make(timer, 0.25)), clock="lockstep")

        assert [0.0, 2.5, 2.75] == found

    def test_in_real_time_it_ends_soon_after_its_time(self, timer):
        """By the simulator's clock, too."""
        begin, *_, first, second = ticks(
            lambda: steps(self.make(timer, 300.0), self.make(timer, 100.0)), real_time_factor=FAST
        )

        assert 300.0 <= first - begin < 300.0 + LATE
        assert 100.0 <= second - first < 100.0 + LATE

    def test_it_goes_on_when_lockstep_ends_under_it(self, timer):
        """The clock is another one, the time is not."""
        switch = Asks("time/set", clock="realtime", real_time_factor=FAST)
        found = ticks(lambda: beside(self.make(timer, 300.0), Alarm(2.0), switch), clock="lockstep")

        assert [0.0, 2.0] == found[:2]
        assert 300.0 <= found[-1] < 300.0 + LATE

    def test_in_lockstep_what_was_waited_for_before_a_reset_counts(self, timer):
        """Ten seconds are ten seconds, though the clock begins anew after eight."""
        found = ticks(lambda: beside(self.make(timer, 10.0), Alarm(8.0), Asks("reset_simulation")), clock="lockstep")

        assert ([0.0, 8.0], 2.0) == (found[:2], found[-1])

    def test_in_real_time_what_was_waited_for_before_a_reset_counts(self, timer):
        """600 seconds of 1,000, so that it is not for another 1,000."""
        reset = Asks("reset_simulation")
        found = ticks(lambda: beside(self.make(timer, 1000.0), Alarm(600.0), reset), real_time_factor=FAST)

        assert found[-1] < 1000.0
