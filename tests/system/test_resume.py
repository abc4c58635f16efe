"""A controller that is killed during its mission resumes it when it is restarted."""

from __future__ import annotations

import json
import signal
from collections import Counter

import pytest

WORLD = {
    "name": "ward",
    "units": "m",
    "waypoints": {"home": [0, 0], "shelf": [3, 0], "bed": [6, 0]},
    "lanes": [["home", "shelf"], ["shelf", "bed"]],
    "items": {"parcel": {"at": [3, 0.3], "weight": 0.1}},
    "robot_types": {"nurse": {"components": {"claw": {"reach": 0.9, "max_weight": 1.0, "handling_time": 1.5}}}},
    "robots": {"wall_e": {"type": "nurse", "at": "home"}},
}

TREE = '''
"""An errand; whoever does it dies in the middle of it, so many times as the file `lives` says."""

import os
import signal
from pathlib import Path

from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy, Status
from py_trees.composites import Parallel, Sequence

from bt_controller.behaviours.robot_actions import Pickup, Place
from bt_controller.behaviours.robot_actions import GoTo
from bt_controller.behaviours.robot_actions import Wait
from bt_controller.loading.trees import resumable

LIVES = Path("lives")


class Die(Behaviour):
    """Kills the process at a tick."""

    ticks = 0

    def update(self):
        self.ticks += 1
        lives, tick = map(int, LIVES.read_text().split())
        if lives and self.ticks == tick:
            LIVES.write_text(f"{lives - 1} {tick}")
            os.kill(os.getpid(), signal.SIGKILL)
        return Status.RUNNING


def errand():
    steps = [GoTo("shelf"), Pickup("parcel"), GoTo("bed"), Wait(2), Place("parcel")]
    errand = Sequence("Errand", memory=True, children=steps)
    policy = ParallelPolicy.SuccessOnSelected(children=[errand], synchronise=False)
    return Parallel("Life", policy=policy, children=[errand, Die("Die")])


@resumable
def marked():
    return errand()
'''

SUCCEEDED = 4
DONE = {"navigate_to_pose": 2, "pickup": 1, "wait": 1, "place": 1}
"""How many goals of each action the errand has."""

CLOCKS = {
    "lockstep": ("--clock", "lockstep"),
    "realtime": ("--real-time-factor", "20"),
    "slow": ("--real-time-factor", "3"),
}


@pytest.fixture
def ward(serve, tmp_path):
    """Return the function that serves the ward: simulator, endpoint and trace."""
    world = tmp_path / "ward.yaml"
    world.write_text(json.dumps(WORLD))
    (tmp_path / "errands.py").write_text(TREE)

    def run(clock):
        trace = tmp_path / "trace.jsonl"
        simulator, endpoint = serve(world, "--trace", trace, *CLOCKS[clock])
        return simulator, endpoint, trace

    return run


@pytest.fixture
def live(start, tmp_path):
    """Return the function that restarts a controller until it ends by itself, and returns the exit codes."""

    def run(endpoint, lives, tick, *options, tree="errands:errand"):
        (tmp_path / "lives").write_text(f"{lives} {tick}")
        command = ("run", tree, "--robot", "wall_e", *options)
        codes = []
        while codes.count(-signal.SIGKILL) == len(codes) < 20:
            codes.append(start("bt-controller", *command, env={"HMRSIM_CONNECT": endpoint}, cwd=tmp_path).end()[0])
        return codes

    return run


def ends(simulator, trace):
    """Return the number of goals by action and status, once the simulator has ended."""
    simulator.end(signal.SIGTERM)
    lines = [json.loads(line) for line in trace.read_text().splitlines()]
    return Counter(
        (line["action"], line["status"]) for line in lines if line["kind"] == "status" and line["status"] > 3
    )


@pytest.mark.parametrize(
    ("clock", "lives", "tick"),
    [
        *(("lockstep", lives, tick) for lives, tick in [(1, 1), (1, 4), (3, 3), (1, 7), (1, 9)]),
        ("realtime", 1, 4),
        ("realtime", 2, 3),
    ],
)
def test_a_killed_controller_repeats_no_step(ward, live, clock, lives, tick):
    simulator, endpoint, trace = ward(clock)
    codes = live(endpoint, lives, tick, "--resume")

    assert [-signal.SIGKILL] * lives + [0] == codes
    assert {(action, SUCCEEDED): number for action, number in DONE.items()} == ends(simulator, trace)


def test_a_tree_can_request_to_be_resumed(ward, live):
    simulator, endpoint, trace = ward("lockstep")
    codes = live(endpoint, 1, 5, tree="errands:marked")

    assert [-signal.SIGKILL, 0] == codes
    assert {(action, SUCCEEDED): number for action, number in DONE.items()} == ends(simulator, trace)


@pytest.mark.parametrize(("tree", "options"), [("errands:errand", ()), ("errands:marked", ("--no-resume",))])
def test_without_resuming_the_mission_starts_again(ward, live, tree, options):
    """It fails, as the parcel is no longer where it was."""
    _, endpoint, _ = ward("lockstep")

    assert [-signal.SIGKILL, 1] == live(endpoint, 1, 9, *options, tree=tree)


def test_a_finished_mission_is_repeated_only_under_another_name(ward, live):
    simulator, endpoint, trace = ward("lockstep")
    codes = [live(endpoint, 0, 0, "--resume", mission) for mission in ("morning", "morning", "evening")]
    counts = ends(simulator, trace)

    assert [[0], [0], [1]] == codes
    assert (1, 1) == (counts["pickup", SUCCEEDED], counts["place", SUCCEEDED])


def test_two_controllers_with_one_mission_do_each_step_once(ward, start, tmp_path):
    simulator, endpoint, trace = ward("realtime")
    (tmp_path / "lives").write_text("0 0")
    command = ("bt-controller", "run", "errands:errand", "--robot", "wall_e", "--resume")
    both = [start(*command, env={"HMRSIM_CONNECT": endpoint}, cwd=tmp_path) for _ in range(2)]

    assert [0, 0] == [controller.end()[0] for controller in both]
    assert {(action, SUCCEEDED): number for action, number in DONE.items()} == ends(simulator, trace)


def test_an_interrupted_controller_resends_its_canceled_step(ward, start, tmp_path):
    simulator, endpoint, trace = ward("slow")
    (tmp_path / "lives").write_text("0 0")
    command = ("bt-controller", "run", "errands:errand", "--robot", "wall_e", "--resume")
    first = start(*command, env={"HMRSIM_CONNECT": endpoint}, cwd=tmp_path)
    first.line_with("Wait 2 s [*]")
    codes = [first.end(signal.SIGINT)[0], start(*command, env={"HMRSIM_CONNECT": endpoint}, cwd=tmp_path).end()[0]]
    counts = ends(simulator, trace)

    assert [130, 0] == codes
    assert DONE == {action: counts[action, SUCCEEDED] for action in DONE}
    assert ["wait"] == [action for action, status in counts if status != SUCCEEDED]
