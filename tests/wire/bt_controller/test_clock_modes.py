"""Timers of py_trees and of XML nodes, in real time, in lockstep, when the clock changes, and after a reset."""

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
    """Succeeds a number of seconds after it started, and names the time of its next tick."""

    def __init__(self, seconds):
        super().__init__(f"Alarm {seconds}")
        self._seconds = seconds

    def initialise(self):
        self._deadline = now() + self._seconds

    def update(self):
        return Status.SUCCESS if reached(self._deadline) else Status.RUNNING

    def next_tick_time(self):
        return self._deadline


class Asks(Behaviour):
    """Calls a service of the simulator, once."""

    def __init__(self, service, **request):
        super().__init__(service)
        self._asked = service, json.dumps(request).encode()

    def setup(self, **kwargs):
        self._client = kwargs["client"]

    def update(self):
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
    """Return a timer in parallel with steps."""
    return Parallel("Both", policy=ParallelPolicy.SuccessOnAll(synchronise=True), children=[timer, steps(*children)])


@pytest.mark.parametrize("timer", [Timer, Alarm], ids=["py_trees", "node"])
class TestTimers:
    @staticmethod
    def make(kind, seconds):
        return Timer(f"Timer {seconds}", seconds) if kind is Timer else Alarm(seconds)

    def test_a_timer_ends_exactly_on_time_in_lockstep(self, timer):
        found = ticks(lambda: steps(self.make(timer, 2.5), self.make(timer, 0.25)), clock="lockstep")

        assert [0.0, 2.5, 2.75] == found

    def test_a_timer_ends_soon_after_its_time_in_real_time(self, timer):
        begin, *_, first, second = ticks(
            lambda: steps(self.make(timer, 300.0), self.make(timer, 100.0)), real_time_factor=FAST
        )

        assert 300.0 <= first - begin < 300.0 + LATE
        assert 100.0 <= second - first < 100.0 + LATE

    def test_a_timer_continues_when_lockstep_ends(self, timer):
        switch = Asks("time/set", clock="realtime", real_time_factor=FAST)
        found = ticks(lambda: beside(self.make(timer, 300.0), Alarm(2.0), switch), clock="lockstep")

        assert [0.0, 2.0] == found[:2]
        assert 300.0 <= found[-1] < 300.0 + LATE

    def test_a_reset_keeps_the_time_waited_in_lockstep(self, timer):
        """The wait takes ten seconds although the clock restarts after eight."""
        found = ticks(lambda: beside(self.make(timer, 10.0), Alarm(8.0), Asks("reset_simulation")), clock="lockstep")

        assert ([0.0, 8.0], 2.0) == (found[:2], found[-1])

    def test_a_reset_keeps_the_time_waited_in_real_time(self, timer):
        """The reset comes at 600 of 1,000 s, so the wait must not take another 1,000 s."""
        reset = Asks("reset_simulation")
        found = ticks(lambda: beside(self.make(timer, 1000.0), Alarm(600.0), reset), real_time_factor=FAST)

        assert found[-1] < 1000.0
