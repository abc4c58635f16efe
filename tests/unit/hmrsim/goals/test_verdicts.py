"""Goals that can't be executed, which are rejected or, as in Nav2, accepted and aborted."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.actions import registry as actions
from hmrsim.protocol.commands import GetResult, SendGoal
from hmrsim.protocol.goal import Verdict
from hmrsim.trace.replay import replay
from tests.profiles import examples
from tests.simulation import simulate

A, B = "a" * 32, "b" * 32
ELSEWHERE = {"header": {"frame_id": "odom"}}

NOT_EXECUTABLE = [
    ("navigate_to_pose", {"pose": ELSEWHERE}, 9002, True),
    ("navigate_through_poses", {"poses": {"goals": [{}, ELSEWHERE]}}, 9102, True),
    ("compute_path_to_pose", {"goal": ELSEWHERE}, 202, False),
    ("compute_path_to_pose", {"planner_id": "SmacHybrid"}, 201, True),
    ("compute_path_through_poses", {"goals": {"goals": [ELSEWHERE]}}, 302, False),
    ("compute_path_through_poses", {"planner_id": "SmacHybrid"}, 301, True),
    ("smooth_path", {"smoother_id": "savitzky_golay"}, 501, True),
    ("follow_path", {"path": {"poses": [{}], **ELSEWHERE}}, 102, False),
    ("follow_path", {"controller_id": "MPPI", "path": {"poses": [{}]}}, 101, True),
    ("follow_path", {"goal_checker_id": "exact", "path": {"poses": [{}]}}, 100, True),
    ("follow_path", {"progress_checker_id": "pace", "path": {"poses": [{}]}}, 100, True),
    ("follow_path", {"path": {"poses": []}}, 103, True),
    ("dock_robot", {"use_dock_id": False, "dock_pose": ELSEWHERE}, 999, False),
    ("spin", {"target_yaw": 1e30}, 700, False),
    ("drive_on_heading", {"target": {"x": 1.0}, "speed": 1e30}, 720, False),
]


def goal(action, fields, verdict, goal_id=A):
    message = actions()[action].goal.model_validate(fields)
    return SendGoal("wall_e", action, message, goal_id, goal_id, verdict)


@pytest.mark.parametrize(("action", "fields", "code", "early"), NOT_EXECUTABLE)
@pytest.mark.parametrize("verdict", Verdict)
def test_verdicts_are_those_of_nav2(run, action, fields, code, early, verdict):
    log = run((0.0, goal(action, fields, verdict)), (0.0, GetResult("wall_e", action, A, "result")))

    rejected = verdict is Verdict.REJECT or (early and verdict is Verdict.ABORT_OR_REJECT)
    assert rejected != log.answer(A).accepted
    if rejected:
        assert "invalid_goal" == log.answer(A).reason
    else:
        assert [(0.0, "ACCEPTED"), (0.0, "EXECUTING"), (0.0, "ABORTED")] == log.changes(A)
        result = log.answer("result").result
        assert (code, True) == (result.error_code, bool(result.error_msg))


@pytest.mark.parametrize(
    "changed", [{"robot": "nobody"}, {"action": "fly"}, {"goal_id": "0" * 32}, {"reply_to": "again"}]
)
def test_requests_without_a_server_or_a_new_id_are_rejected(run, changed):
    known = goal("wait", {"time": {"sec": 5}}, Verdict.ABORT)
    log = run((0.0, known), (1.0, known._replace(**({"reply_to": "bad"} | changed))))

    assert not log.answer(changed.get("reply_to", "bad")).accepted
    assert (5.0, "SUCCEEDED") == log.changes(A)[-1]


def test_a_robot_that_is_not_ready_aborts_the_goal(make_run):
    """Nav2's navigator accepts a goal and fails if no planner is there."""
    run = make_run({"robots": {"wall_e": {"at": [0, 0], "planner": "external"}}})
    log = run((0.0, goal("navigate_to_pose", {}, Verdict.ABORT)))

    assert "ABORTED" == log.changes(A)[-1][1]
    assert "no" in log.result(A).error_msg


def test_an_aborted_goal_does_not_preempt(run):
    bad = goal("navigate_to_pose", {"pose": ELSEWHERE}, Verdict.ABORT, B)
    log = run((0.0, goal("wait", {"time": {"sec": 5}}, Verdict.ABORT)), (1.0, bad))

    assert ["SUCCEEDED", "ABORTED"] == [log.changes(each)[-1][1] for each in (A, B)]


def test_waypoints_in_unknown_frames_are_missed(run):
    """Nav2's waypoint follower continues with the next waypoint."""
    fields = {"poses": [ELSEWHERE, {"pose": {"position": {"x": 5.0, "y": 2.0}}}]}
    log = run((0.0, goal("follow_waypoints", fields, Verdict.ABORT)))
    rejected = goal("follow_waypoints", fields, Verdict.REJECT, B)

    assert "SUCCEEDED" == log.changes(A)[-1][1]
    assert [(0, 9002)] == [(one.waypoint_index, one.error_code) for one in log.result(A).missed_waypoints]
    assert not run((0.0, rejected)).answer(B).accepted


@examples(20)
@given(st.lists(st.tuples(st.sampled_from(NOT_EXECUTABLE), st.sampled_from(Verdict)), min_size=1, max_size=6))
def test_runs_with_aborted_goals_replay(sent):
    run = simulate(traced=True)
    ids = [f"{number:032x}" for number in range(1, len(sent) + 1)]
    log = run(*((float(i), goal(each[0], each[1], verdict, ids[i])) for i, (each, verdict) in enumerate(sent)))
    run.simulator.stop()

    assert replay(run.lines()).difference is None
    for goal_id in ids:
        assert log.answer(goal_id).accepted == (["ABORTED"] == [status for _, status in log.changes(goal_id)][2:])


def test_executable_goals_have_equal_traces():
    lines = []
    for verdict in (Verdict.REJECT, Verdict.ABORT):
        run = simulate(traced=True)
        run((0.0, goal("follow_path", {"path": {"poses": [{}]}}, verdict)))
        run.simulator.stop()
        lines.append(run.lines())

    assert lines[0] == lines[1]
