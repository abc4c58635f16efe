"""Following a path, and another one in its place."""

from __future__ import annotations

import pytest

from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.nav2_msgs import FollowPath, Wait
from hmrsim.protocol.commands import SendGoal


def follow(goal_id, *points, **fields):
    """Return the command to follow a path through points."""
    poses = [{"pose": {"position": {"x": float(x), "y": float(y)}}} for x, y in points]
    goal = FollowPath.Goal.model_validate({"path": {"poses": poses}, **fields})
    return SendGoal("wall_e", "follow_path", goal, goal_id * (32 // len(goal_id)), goal_id)


def world(**base):
    """Return a world of one robot, and nothing in its way."""
    return {"robots": {"wall_e": {"at": [0, 0], "base": {"speed": 1.0, **base}}}}


@pytest.mark.parametrize(("base", "seconds"), [({}, 10.0), ({"acceleration": 0.5}, 12.0)])
def test_the_same_way_in_pieces_takes_as_long_as_in_one(make_run, base, seconds):
    """A new path each second, from where the robot is then: it neither jumps nor stops."""
    whole = make_run(world(**base))((0.0, follow("a", (10, 0))))
    run = make_run(world(**base))
    for second, goal_id in enumerate("abcdef"):
        run.simulator.advance(float(second))
        here = run.simulator.robots["wall_e"].pose().point
        run.simulator.submit(follow(goal_id, here, (10, 0)))
    run.simulator.run()

    assert (seconds, "SUCCEEDED") == whole.changes("a" * 32)[-1]
    assert (pytest.approx(seconds), "SUCCEEDED") == run.log.changes("f" * 32)[-1]


def test_a_path_that_leads_elsewhere_is_begun_from_rest(make_run):
    """A robot that rolls at 1 m/s turns aside as one that stands there: 2 m take 2 s to be as fast, and 2 to stop."""
    run = make_run(world(acceleration=0.5))
    log = run((0.0, follow("a", (10, 0))), (4.0, follow("b", (3, 0), (3, 2))))

    assert (8.0, "SUCCEEDED") == log.changes("b" * 32)[-1]


def test_a_controller_that_there_is_not_is_rejected(run):
    """As an unknown one is by Nav2's server."""
    answer = run((0.0, follow("a", (2, 2), controller_id="MPPI"))).answer("a")

    assert (False, "invalid_goal", 1) == (answer.accepted, answer.reason, answer.error_code)
    assert "no controller 'MPPI'; there is one, called FollowPath" == answer.error_msg


@pytest.mark.parametrize("controller", ["", "FollowPath"])
def test_the_one_controller_has_two_names(run, controller):
    """None, and the one that Nav2's own trees use."""
    assert "SUCCEEDED" == run((0.0, follow("a", (2, 2), controller_id=controller))).changes("a" * 32)[-1][1]


def test_a_repeated_path_does_not_restart_the_patience(make_run):
    """A path each second does not make a robot more patient: it gives up 20 s after it has come to what is in its way.

    Nav2's progress checker counts on, too, when its controller is given another path.
    """
    waypoints = {"start": [0, 0], "middle": [4, 0], "end": [8, 0]}
    lanes = {"waypoints": waypoints, "lanes": [["start", "middle"], ["middle", "end"]]}
    robots = {"wall_e": {"at": "start", "base": {"speed": 1.0}}, "eve": {"at": "end", "base": {"speed": 1.0}}}
    run = make_run({**lanes, "traffic": {"policy": "reserve", "patience": 20.0}, "robots": robots})
    run.simulator.submit(SendGoal("eve", "wait", Wait.Goal(time=Duration(sec=99)), "e" * 32, "eve"))
    for second in range(24):
        run.simulator.advance(float(second))
        here = run.simulator.robots["wall_e"].pose().point
        run.simulator.submit(follow(f"{second + 1:032x}", here, *([(4, 0)] if here[0] < 4 else []), (8, 0)))
    run.simulator.advance(30.0)

    assert (24.0, "ABORTED") == run.log.changes(f"{24:032x}")[-1]
    assert "blocked for 20 s at (4, 0): by eve" == run.log.result(f"{24:032x}").error_msg
