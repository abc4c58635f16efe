"""Robots that are moved at velocities, without a goal."""

from __future__ import annotations

import math
from functools import partial

import pytest

from hmrsim.interfaces.simulation_interfaces import Result
from hmrsim.trace.replay import replay
from tests import simulation
from tests.simulation import simulate

GOAL = "a" * 32
WORLD = {
    "bounds": [0, 0, 20, 10],
    "waypoints": {"a": [2, 2], "b": [8, 2]},
    "lanes": [["a", "b"]],
    "walls": [[[5, 4], [5, 6]]],
    "robot_types": {"slow": {"base": {"speed": 2.0, "turning_rate": 1.0}}},
    "robots": {"r": {"type": "slow", "at": "a"}, "other": {"at": "b"}},
}


@pytest.fixture
def run():
    return simulate(WORLD, traced=True)


def steer(run, linear, angular=0.0):
    """Set velocities of the robot; return the code and the text of the result."""
    result = run.ask("set_velocity", {"robot": "r", "linear": linear, "angular": angular}).result
    return result.result, result.error_message


def pose(run):
    return run.simulator.robots["r"].pose()


go = partial(simulation.go, y=2.0, robot="r")


def test_a_robot_moves_as_long_as_velocities_come(run):
    for at in (0.0, 0.2, 0.4):
        run(until=at)
        steer(run, 1.0)
    run(until=0.8)
    underway = pose(run)
    run()

    assert pytest.approx((2.8, 2.0, 0.0)) == underway
    assert pytest.approx((2.9, 2.0, 0.0)) == pose(run)


@pytest.mark.parametrize(
    ("linear", "angular", "expected"),
    [
        (-1.0, 0.0, (1.5, 2.0, 0.0)),
        (0.0, -0.8, (2.0, 2.0, -0.4)),
        # No faster than the base can.
        (9.0, 0.0, (3.0, 2.0, 0.0)),
        (0.0, 7.0, (2.0, 2.0, 0.5)),
        # An arc of radius 1, of five chords.
        (1.0, 1.0, (2.0 + math.sin(0.5), 3.0 - math.cos(0.5), 0.5)),
        (0.0, 0.0, (2.0, 2.0, 0.0)),
    ],
)
def test_a_command_applies_for_half_a_second(run, linear, angular, expected):
    code, _ = steer(run, linear, angular)
    run()

    assert Result.RESULT_OK == code
    assert pytest.approx(expected, abs=0.001) == pose(run)


def test_a_wall_stops_the_robot(run):
    run.ask("set_entity_state", {"entity": "r", "state": {"pose": {"position": {"x": 4.7, "y": 5.0}}}})
    code, text = steer(run, 1.0)
    run()

    assert Result.RESULT_OPERATION_FAILED == code
    assert "r stops before an obstacle at (5, 5)" == text
    assert pytest.approx((5.0, 5.0, 0.0), abs=1e-5) == pose(run)
    assert pose(run).x < 5.0


def test_a_goal_comes_before_velocities(run):
    run((0.0, go(8.0)), until=1.0)
    code, text = steer(run, -1.0)
    run()

    assert Result.RESULT_INCORRECT_STATE == code
    assert f"r executes navigate_to_pose goal {GOAL}; cancel it first" == text
    assert "SUCCEEDED" == run.log.changes(GOAL)[-1][1]


def test_a_goal_takes_over_from_velocities(run):
    steer(run, 1.0)
    run((0.2, go(8.0)))

    assert "SUCCEEDED" == run.log.changes(GOAL)[-1][1]
    assert pytest.approx((8.0, 2.0)) == pose(run).point


def test_unknown_and_disabled_robots_are_refused(run):
    run.ask("inject_fault", {"type": "breakdown", "settings": '{"robot": "r"}'})
    unknown = run.ask("set_velocity", {"robot": "nobody"}).result

    assert Result.RESULT_INCORRECT_STATE == steer(run, 1.0)[0]
    assert (Result.RESULT_NOT_FOUND, True) == (unknown.result, "no robot 'nobody'" in unknown.error_message)


def test_a_breakdown_stops_the_robot(run):
    steer(run, 1.0)
    run(until=0.2)
    run.ask("inject_fault", {"type": "breakdown", "settings": '{"robot": "r"}'})
    run()

    assert pytest.approx((2.2, 2.0)) == pose(run).point


def test_a_replay_repeats_velocities(run):
    steer(run, 1.0, 0.5)
    run(until=0.2)
    steer(run, -1.0)
    run()

    assert None is replay(run.lines()).difference
