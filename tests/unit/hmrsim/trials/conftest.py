"""A small world in which controllers are disturbed."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from hmrsim.actions import registry
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.nav2_msgs import Wait
from hmrsim.settings.run import RunSettings
from hmrsim.trace.replay import replay
from hmrsim.trace.writer import DeferredTrace
from hmrsim.trials.disturbances import Disturbance, Disturber
from hmrsim.trials.local import LocalTrial
from hmrsim.world.model import World

WORLD = World.model_validate(
    {
        "waypoints": {"a": [0, 0], "b": [10, 0], "c": [20, 0]},
        "lanes": [["a", "b"], ["b", "c"]],
        "robots": {"ann": {"at": "a"}, "bob": {"at": "c"}},
    }
)


class Waiting:
    """A controller that sends a robot goals to wait, again and again.

    Attributes:
        times: The start of each run, and the end of each of its goals.
    """

    def __init__(self, *seconds, robot="ann"):
        self.times = []
        self._seconds = seconds
        self._robot = robot

    def __call__(self, client, _robots):
        times = []
        self.times.append(times)
        times.append(client.now)
        wait = client.action_client(self._robot, registry()["wait"])
        for each in self._seconds:
            wait.send_goal(Wait.Goal(time=Duration.from_seconds(each))).result()
            times.append(client.now)
        return True


@pytest.fixture
def waiting():
    """Return a function that makes such controllers."""
    return Waiting


@pytest.fixture
def disturbed():
    """Return a function that runs a controller while it is disturbed."""

    def run(controller, *disturbances, duration=1000.0):
        settings = RunSettings(duration=duration, clock="lockstep")
        trace = DeferredTrace(WORLD, settings)
        disturber = Disturber([Disturbance.model_validate(each) for each in disturbances])

        def watchers(simulator, pacing):
            return [disturber.watch(simulator, pacing)]

        there = {"sinks": [trace], "watchers": watchers, "disturber": disturber}
        with LocalTrial(WORLD, settings, controller, name="nurse", **there) as trial:
            ending, cause, _ = trial.play()
        text = trace.whole(trial.simulator.now)
        return SimpleNamespace(
            ending=ending,
            cause=cause,
            trace=text,
            acted=[(each.at / 1e9, each.disturbance.disturbance) for each in disturber.acted],
            replay=replay(text.splitlines(keepends=True)),
        )

    return run
