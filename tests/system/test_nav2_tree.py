"""Navigation with Nav2's default tree, unmodified, and with an equivalent tree of ours."""

from __future__ import annotations

import json
import signal
from pathlib import Path

import pytest
import yaml
from py_trees.common import Status

from bt_controller.loading.trees import load
from bt_controller.running.clocks import Mailbox, clock_for
from bt_controller.running.mission import Mission
from bt_controller.running.runner import Runner
from hmrsim_zenoh.client.client import Client
from tests.paths import nav2_files
from tests.served_world import served_world

NAV2 = "navigate_to_pose_w_replanning_and_recovery.xml"
THEIRS = next((file for file in nav2_files(".xml") if file.name == NAV2), Path(NAV2))
OURS = Path(__file__).with_name("navigate.xml")

GOAL = "14;0"
"""14 m down the corridor."""

CORRIDOR = {
    "name": "corridor",
    "bounds": [-5, -5, 40, 6],
    "waypoints": {"start": [0, 0], "fork": [4, 0], "join": [10, 0], "end": [14, 0], "far": [30, 0], "isle": [34, 0]},
    "lanes": [["start", "fork"], ["fork", "join"], ["join", "end"], ["far", "isle"]],
    "walls": [[[20, -5], [20, 6]]],
    "robots": {"r": {"at": "start"}},
}
LOOP = {
    **CORRIDOR,
    "waypoints": {**CORRIDOR["waypoints"], "left": [4, 4], "right": [10, 4]},
    "lanes": [*CORRIDOR["lanes"], ["fork", "left"], ["left", "right"], ["right", "join"]],
}


def closing(world, *lane, at, until=None):
    """Return a world in which a lane is closed at some time."""
    fault = {"type": "lane_closed", "lane": [*lane], "at": at, **({"until": until} if until else {})}
    return {**world, "faults": [fault]}


@pytest.fixture(
    params=[
        pytest.param(OURS, id="ours"),
        pytest.param(THEIRS, id="nav2", marks=pytest.mark.skipif(not THEIRS.exists(), reason=f"there is no {NAV2}")),
    ]
)
def tree(request):
    return request.param


@pytest.fixture
def navigate(start, tree, tmp_path):
    """Return the function that runs the tree for r in a process: exit code, output and trace."""

    def run(world, goal=GOAL, clock="lockstep", **env):
        file, trace = tmp_path / "world.yaml", tmp_path / "trace.jsonl"
        file.write_text(yaml.safe_dump({"units": "m", **world}))
        serving = ("--clock", clock, "--listen", "tcp/127.0.0.1:0", "--trace", trace)
        simulator = start("hmrsim", "run", file, *serving, env=env)
        endpoint = simulator.line().split()[1]
        options = ("--robot", "r", "--set", f"goal={goal}", "--connect", endpoint)
        code, out, _ = start("bt-controller", "run", tree, *options, env=env).end()
        simulator.end(signal.SIGTERM)
        return code, out, [json.loads(line) for line in trace.read_text().splitlines()]

    return run


@pytest.fixture
def driven(tree):
    """Return the function that runs the tree for r in lockstep: its status, its end, and its blackboard."""

    def run(world, goal=GOAL):
        plan = load(str(tree), values={"goal": goal})
        with served_world(world, clock="lockstep") as options, Client(options, name="trees") as client:
            mission, mailbox = Mission("r", plan), Mailbox()
            clock = clock_for(client, mailbox, feedback=False, grace=0.1)
            runner = Runner(client, [mission], clock, mailbox, show=lambda *_: None, grace=5.0)
            outcome = runner.run()
            return outcome.statuses["r"], round(clock.now, 3), dict(mission._board.storage)

    return run


def codes(board):
    """Return the error codes on a blackboard that are not success, with their messages."""
    return sorted(value for key, value in board.items() if key.endswith(("error", "error_code")) and value)


def goals(trace, action):
    sent = [line for line in trace if line["kind"] == "command" and line.get("action") == action]
    return [(line["stamp"]["sec"], line["goal"]) for line in sent if line["command"] == "send_goal"]


def ends(trace):
    """Return the actions and statuses of the ended goals, in order."""
    statuses = [line for line in trace if line["kind"] == "status" and line["status"] >= 4]
    return [(line["action"], line["status"]) for line in statuses]


def test_the_tree_navigates_over_zenoh_in_real_time(navigate):
    code, out, trace = navigate(CORRIDOR, goal="2;0", clock="realtime")

    assert (0, "r: SUCCESS") == (code, out.splitlines()[-1])
    assert ("follow_path", 4) == ends(trace)[-1]


@pytest.mark.parametrize(("base", "seconds"), [({}, 14.0), ({"acceleration": 0.5}, 16.0)])
def test_a_robot_neither_jumps_nor_stops_when_its_path_is_replaced(driven, base, seconds):
    """14 m at 1 m/s take 14 s although the path is planned each second."""
    robots = {"r": {"at": "start", "base": {"speed": 1.0, **base}}}

    assert (Status.SUCCESS, seconds) == driven({**CORRIDOR, "robots": robots})[:2]


def test_paths_are_planned_each_second_until_the_goal_is_near(navigate):
    _, _, trace = navigate(CORRIDOR)
    planned = [second for second, _ in goals(trace, "compute_path_to_pose")]

    assert planned == sorted(set(planned))
    assert [0, 1, 2, 3] == planned[:4]
    assert 10 <= planned[-1] <= 12
    assert planned == [second for second, _ in goals(trace, "follow_path")]


def test_a_lane_that_closes_ahead_is_avoided(driven):
    """It closes at 2 s, and the detour is 8 m longer."""
    status, seconds, board = driven(closing(LOOP, "fork", "join", at=2))

    assert (Status.SUCCESS, 22.0) == (status, seconds)
    assert [] == codes(board)


def test_a_closed_lane_without_a_detour_is_awaited(navigate):
    code, _, trace = navigate(closing(CORRIDOR, "join", "end", at=3, until=9))
    recoveries = [action for action, status in ends(trace) if action in ("spin", "wait", "back_up") and status == 4]

    assert 0 == code
    assert ("compute_path_to_pose", 6) in ends(trace)
    assert ["spin", "wait"] == recoveries[:2]
    assert ("follow_path", 4) == ends(trace)[-1]


def test_a_lane_that_closes_near_the_goal_is_noticed(driven):
    """The path is only checked there, not planned again, and the lane opens in time."""
    corridor = {**CORRIDOR, "waypoints": {**CORRIDOR["waypoints"], "door": [13, 0]}}
    corridor["lanes"] = [["start", "fork"], ["fork", "join"], ["join", "door"], ["door", "end"]]
    status, seconds, _ = driven(closing(corridor, "door", "end", at=12.2, until=17))

    assert Status.SUCCESS is status
    assert 18.0 < seconds < 30.0


@pytest.mark.parametrize(
    ("world", "goal", "code"),
    [(CORRIDOR, "100;0", 204), (CORRIDOR, "32;0", 208), (closing(CORRIDOR, "join", "end", at=3), GOAL, 208)],
    ids=["outside the map", "no way", "closed for ever"],
)
def test_an_unreachable_goal_is_a_failure_with_the_code_on_the_blackboard(driven, world, goal, code):
    """Code 204 fails at once, as no recovery helps, and 208 after all recoveries."""
    status, seconds, board = driven(world, goal)

    assert Status.FAILURE is status
    assert [code] == codes(board)
    assert (seconds == 0.0) is (code == 204)


def test_a_robot_that_stays_in_the_way_is_a_failure(driven):
    robots = {"r": {"at": "start"}, "s": {"at": "join", "script": ["Wait 1000"]}}
    status, _, board = driven({**CORRIDOR, "robots": robots, "traffic": {"policy": "reserve", "patience": 10}})

    assert Status.FAILURE is status
    assert [104] == codes(board)
