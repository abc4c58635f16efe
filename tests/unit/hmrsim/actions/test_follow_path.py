"""Following a path, and replacing it with another one."""

from __future__ import annotations

import pytest

from tests.simulation import at, send


def follow(goal_id, *points, **fields):
    return send(
        "follow_path",
        goal_id * (32 // len(goal_id)),
        reply_to=goal_id,
        path={"poses": [at(*p) for p in points]},
        **fields,
    )


def world(**base):
    return {"robots": {"wall_e": {"at": [0, 0], "base": {"speed": 1.0, **base}}}}


@pytest.mark.parametrize(("base", "seconds"), [({}, 10.0), ({"acceleration": 0.5}, 12.0)])
def test_replacing_the_path_with_its_remainder_takes_no_time(make_run, base, seconds):
    """With a new path each second from its current pose, the robot neither jumps nor stops."""
    whole = make_run(world(**base))((0.0, follow("a", (10, 0))))
    run = make_run(world(**base))
    for second, goal_id in enumerate("abcdef"):
        run.simulator.advance(float(second))
        here = run.simulator.robots["wall_e"].pose().point
        run.simulator.submit(follow(goal_id, here, (10, 0)))
    run.simulator.run()

    assert (seconds, "SUCCEEDED") == whole.changes("a" * 32)[-1]
    assert (pytest.approx(seconds), "SUCCEEDED") == run.log.changes("f" * 32)[-1]


def test_a_path_in_another_direction_begins_from_rest(make_run):
    """A robot at 1 m/s that turns aside takes as long as one at rest: 2 s to accelerate on 2 m, and 2 s to stop."""
    run = make_run(world(acceleration=0.5))
    log = run((0.0, follow("a", (10, 0))), (4.0, follow("b", (3, 0), (3, 2))))

    assert (8.0, "SUCCEEDED") == log.changes("b" * 32)[-1]


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"controller_id": "MPPI"}, "no controller 'MPPI'; there is one, called FollowPath"),
        ({"goal_checker_id": "exact"}, "no goal checker 'exact'; there is one, called general_goal_checker"),
        ({"progress_checker_id": "pace"}, "no progress checker 'pace'; there is one, called progress_checker"),
    ],
)
def test_an_unknown_plugin_is_rejected(run, fields, message):
    """Nav2's controller_server does not drive with a plugin that it has not loaded, either."""
    answer = run((0.0, follow("a", (2, 2), **fields))).answer("a")

    assert (False, "invalid_goal", message) == (answer.accepted, answer.reason, answer.error_msg)


@pytest.mark.parametrize(
    "fields",
    [
        {"controller_id": "FollowPath"},
        {"goal_checker_id": "general_goal_checker", "progress_checker_id": "progress_checker"},
        {"goal_checker_id": "goal_checker"},
    ],
)
def test_the_names_of_nav2_stand_for_the_only_plugin(run, fields):
    """They are those of its parameters, its trees and its code."""
    assert "SUCCEEDED" == run((0.0, follow("a", (2, 2), **fields))).changes("a" * 32)[-1][1]


def test_a_repeated_path_does_not_restart_the_patience(make_run):
    """Nav2's progress checker also keeps counting when its controller gets another path."""
    waypoints = {"start": [0, 0], "middle": [4, 0], "end": [8, 0]}
    lanes = {"waypoints": waypoints, "lanes": [["start", "middle"], ["middle", "end"]]}
    robots = {"wall_e": {"at": "start", "base": {"speed": 1.0}}, "eve": {"at": "end", "base": {"speed": 1.0}}}
    run = make_run({**lanes, "traffic": {"policy": "reserve", "patience": 20.0}, "robots": robots})
    for second in range(24):
        run.simulator.advance(float(second))
        here = run.simulator.robots["wall_e"].pose().point
        run.simulator.submit(follow(f"{second + 1:032x}", here, *([(4, 0)] if here[0] < 4 else []), (8, 0)))
    run.simulator.advance(30.0)

    assert (24.0, "ABORTED") == run.log.changes(f"{24:032x}")[-1]
    text = "blocked for 20 s: wall_e has waited at middle since 4 s for eve"
    assert run.log.result(f"{24:032x}").error_msg.startswith(text)


def tracked(log, goal_id="a" * 32):
    found = {}
    for time, feedback in log.feedback(goal_id):
        one = feedback.tracking_feedback
        errors = one.position_tracking_error, one.heading_tracking_error
        found[round(time, 6)] = (*errors, one.current_path_index, one.distance_to_goal, one.remaining_path_length)
    return found


def test_feedback_reports_the_tracking_error(make_run):
    found = tracked(make_run(world())((0.0, follow("a", (0, 0), (4, 0), (4, 3)))))

    assert pytest.approx((0.0, 0.0, 0, 3.605551, 5.0)) == found[2.0]
    assert pytest.approx((0.0, 0.0, 1, 2.0, 2.0)) == found[5.0]


def test_a_robot_that_turns_in_place_has_a_heading_error(make_run):
    found = tracked(make_run(world(turning_rate=1.0))((0.0, follow("a", (0, 0), (4, 0), (4, 3)))))

    assert pytest.approx((0.0, -0.5, 0)) == found[4.5][:3]


@pytest.mark.parametrize(("dy", "error"), [(0.4, 0.4), (-0.4, -0.4)])
def test_a_localization_error_shows_as_tracking_error(make_run, dy, error):
    fault = {"type": "localisation_jump", "robot": "wall_e", "dy": dy, "at": 1}
    found = tracked(make_run(world() | {"faults": [fault]})((0.0, follow("a", (0, 0), (10, 0)))))

    assert pytest.approx((error, 0.0, 0)) == found[2.0][:3]


def test_at_a_crossing_of_a_path_with_itself_progress_decides_the_segment(make_run):
    found = tracked(make_run(world())((0.0, follow("a", (0, 0), (10, 0), (10, 5), (5, 5), (5, -5)))))

    assert [0, 3, 3] == [found[time][2] for time in (5.0, 21.0, 24.9)]


def test_a_path_of_one_pose_has_only_a_distance_error(make_run):
    found = tracked(make_run(world())((0.0, follow("a", (4, 0)))))

    assert pytest.approx((3.0, 0.0, 0, 3.0, 0.0)) == found[1.0]
