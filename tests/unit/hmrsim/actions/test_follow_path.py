"""Following a path, and another one in its place."""

from __future__ import annotations

import pytest

from hmrsim.interfaces.nav2_msgs import FollowPath
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
    for second in range(24):
        run.simulator.advance(float(second))
        here = run.simulator.robots["wall_e"].pose().point
        run.simulator.submit(follow(f"{second + 1:032x}", here, *([(4, 0)] if here[0] < 4 else []), (8, 0)))
    run.simulator.advance(30.0)

    assert (24.0, "ABORTED") == run.log.changes(f"{24:032x}")[-1]
    by = "eve, idle at end since 0 s; it makes no room under the policy 'reserve'; others do"
    assert f"blocked for 20 s at middle by {by}" == run.log.result(f"{24:032x}").error_msg


def tracked(log, goal_id="a" * 32):
    """Return how a robot keeps to its path, by time: errors, index, straight and remaining length."""
    found = {}
    for time, feedback in log.feedback(goal_id):
        one = feedback.tracking_feedback
        errors = one.position_tracking_error, one.heading_tracking_error
        found[round(time, 6)] = (*errors, one.current_path_index, one.distance_to_goal, one.remaining_path_length)
    return found


def test_feedback_tells_how_the_robot_keeps_to_its_path(make_run):
    """The segment that it is on, and what is left, straight and along the path."""
    found = tracked(make_run(world())((0.0, follow("a", (0, 0), (4, 0), (4, 3)))))

    assert pytest.approx((0.0, 0.0, 0, 3.605551, 5.0)) == found[2.0]
    assert pytest.approx((0.0, 0.0, 1, 2.0, 2.0)) == found[5.0]


def test_a_robot_that_turns_on_the_spot_has_a_heading_error(make_run):
    """Half a radian to the left of the segment that it has driven: the error says how far it would have to turn."""
    found = tracked(make_run(world(turning_rate=1.0))((0.0, follow("a", (0, 0), (4, 0), (4, 3)))))

    assert pytest.approx((0.0, -0.5, 0)) == found[4.5][:3]


@pytest.mark.parametrize(("dy", "error"), [(0.4, 0.4), (-0.4, -0.4)])
def test_a_robot_that_is_wrong_about_its_pose_sees_itself_beside_its_path(make_run, dy, error):
    """Left of it is positive."""
    fault = {"type": "localisation_jump", "robot": "wall_e", "dy": dy, "at": 1}
    found = tracked(make_run(world() | {"faults": [fault]})((0.0, follow("a", (0, 0), (10, 0)))))

    assert pytest.approx((error, 0.0, 0)) == found[2.0][:3]


def test_on_a_path_that_crosses_itself_the_robot_is_where_it_has_come_to(make_run):
    """At the crossing it is on the first part, later on the last one."""
    found = tracked(make_run(world())((0.0, follow("a", (0, 0), (10, 0), (10, 5), (5, 5), (5, -5)))))

    assert [0, 3, 3] == [found[time][2] for time in (5.0, 21.0, 24.9)]


def test_a_path_of_one_pose_has_no_direction(make_run):
    """Only how far it is away."""
    found = tracked(make_run(world())((0.0, follow("a", (4, 0)))))

    assert pytest.approx((3.0, 0.0, 0, 3.0, 0.0)) == found[1.0]
