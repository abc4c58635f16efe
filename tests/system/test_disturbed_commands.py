"""Commands that are disturbed while they control robots over Zenoh."""

from __future__ import annotations

import json
import sys
import threading

import pytest

from hmrsim.settings.run import RunSettings
from hmrsim.trace.replay import replay
from hmrsim.trace.writer import DeferredTrace
from hmrsim.trials.command import CommandTrial, ControllerProcess
from hmrsim.trials.disturbances import Disturbance, Disturber
from hmrsim.world_checks.loading import load_world
from tests.patience import PATIENCE

pytestmark = pytest.mark.system

WORLD = """
waypoints: {a: [0, 0], b: [10, 0]}
lanes: [[a, b]]
robots: {ann: {at: a}}
faults: [{type: lane_closed, lane: [a, b], at: 0}]
"""
CONTROLLER = """
import os
from hmrsim.actions import registry
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.nav2_msgs import Wait
from hmrsim_zenoh import Client
from hmrsim_zenoh.wire.options import SessionOptions

with Client(SessionOptions(connect=(os.environ["HMRSIM_CONNECT"],)), name="nurse") as client:
    wait = client.action_client("ann", registry()["wait"])
    for _ in range(3):
        print(client.now, flush=True)
        wait.send_goal(Wait.Goal(time=Duration.from_seconds(10.0))).result()
print("done")
"""


def executing(**more):
    """Return the anchor of ann's goals to wait."""
    return {"goal": "executing", "robot": "ann", "action": "wait", **more}


KILLED = {"disturbance": "controller_killed", "when": executing(after=4.0)}
SECOND = {"disturbance": "second_controller", "when": executing(after=4.0)}


@pytest.fixture
def disturbed(tmp_path):
    """Return a function that runs the disturbed controller and returns its outcome and its trace."""
    (tmp_path / "world.yaml").write_text(WORLD)
    (tmp_path / "controller.py").write_text(CONTROLLER)

    def run(*disturbances, duration=600.0, on_act=lambda _acted: None):
        loaded = load_world(str(tmp_path / "world.yaml"))
        settings = RunSettings(duration=duration, clock="lockstep")
        trace = DeferredTrace(loaded.world, settings)
        disturber = Disturber([Disturbance.model_validate(each) for each in disturbances], on_act)

        def watchers(simulator, pacing):
            return [disturber.watch(simulator, pacing)]

        words = [sys.executable, "controller.py"]
        with CommandTrial(
            loaded, settings, words, tmp_path, {}, sinks=[trace], watchers=watchers, disturber=disturber
        ) as trial:
            ended = trial.play()
        text = trace.whole(trial.simulator.now)
        assert replay(text.splitlines(keepends=True)).difference is None
        return ended, text

    return run


def goals(trace):
    lines = map(json.loads, trace.splitlines())
    return [(line["stamp"]["sec"], line["by"]) for line in lines if line.get("command") == "send_goal"]


def test_a_killed_command_restarts_at_the_same_simulated_time(disturbed):
    ended, trace = disturbed(KILLED | {"restart_after": 3.0})

    assert ("succeeded", "", "7.0\n17.0\n27.0\ndone") == ended
    assert [(0, "nurse"), (7, "nurse"), (17, "nurse"), (27, "nurse")] == goals(trace)


def test_a_command_is_killed_as_soon_as_it_was_started(disturbed, monkeypatch):
    """The disturbance may be due before this process knows that the command has started or joined."""
    acts = [threading.Event(), threading.Event()]
    done, late = iter(acts), iter(acts)

    class LateProcess(ControllerProcess):
        """A process that is not known to run before its disturbance is due."""

        def __init__(self, *args):
            super().__init__(*args)
            if act := next(late, None):
                act.wait(PATIENCE)

    monkeypatch.setattr("hmrsim.trials.command.ControllerProcess", LateProcess)
    at_once = KILLED | {"when": {"event": "fault_began"}, "restart_after": 3.0}
    again = KILLED | {"when": executing(nth=2), "restart_after": 2.0}
    ended, _ = disturbed(at_once, again, on_act=lambda _acted: next(done).set())

    assert ("succeeded", "", "5.0\n15.0\n25.0\ndone") == ended


def test_a_stalled_command_continues_with_its_next_goal(disturbed):
    _, trace = disturbed({"disturbance": "controller_stalled", "when": executing(after=4.0), "duration": 20.0})

    assert [0, 24, 34] == [at for at, _ in goals(trace)]


def test_a_command_repeats_a_request_whose_answer_was_lost(disturbed):
    """The second answer may be lost, too."""
    _, trace = disturbed({"disturbance": "reply_lost", "when": executing(after=4.0), "count": 2})

    assert [0, 10, 20] == [at for at, _ in goals(trace)]


def test_all_disturbances_give_the_same_trace_again(disturbed):
    disturbances = [
        SECOND,
        {"disturbance": "request_repeated", "when": executing(nth=2), "count": 2},
        {"disturbance": "controller_stalled", "when": executing(nth=2), "duration": 2.5},
        KILLED | {"when": executing(nth=3, after=1.0), "restart_after": 2.0},
        {"disturbance": "simulation_reset", "when": executing(nth=4, after=1.0)},
    ]
    (ended, first), (_, second) = disturbed(*disturbances), disturbed(*disturbances)

    assert "succeeded" == ended.ending
    assert {"nurse", "nurse_2"} == {by for _, by in goals(first)}
    assert first == second
