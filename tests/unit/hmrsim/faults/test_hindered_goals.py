"""Faults that reject or abort goals."""

from __future__ import annotations

import pytest

from hmrsim.errors import WorldError
from hmrsim.interfaces.nav2_msgs import ComputePathToPose
from hmrsim.protocol.commands import CancelGoal, SendGoal
from hmrsim.world_checks.loading import world_of
from tests import simulation
from tests.simulation import SMALL_WORLD, A, B, C, send, simulate, wait


def go(x, goal_id=A, robot="wall_e", reply_to=None):
    return simulation.go(x, 2.0, goal_id, robot, reply_to)


def faulty(*faults, **settings):
    return simulate({**SMALL_WORLD, "faults": [*faults]}, **settings)


def refuses(**keys):
    return {"type": "goals_rejected", "robot": "wall_e", **keys}


def fails(**keys):
    return {"type": "goals_aborted", "robot": "wall_e", **keys}


def ended(log):
    return [time for time, _ in log.happened("fault_ended")]


@pytest.mark.parametrize(
    ("keys", "reason", "message"),
    [({}, "busy", "wall_e is busy with something else"), ({"reason": "not_ready"}, "not_ready", "wall_e is not ready")],
)
def test_goals_are_rejected_while_it_lasts(keys, reason, message):
    log = faulty(refuses(until=2.0, **keys))((1.0, go(9, reply_to="A")), (2.0, go(9, B, reply_to="B")))

    answer = log.answer("A")
    assert (False, reason, message) == (answer.accepted, answer.reason, answer.error_msg)
    assert log.answer("B").accepted


def test_goals_of_one_action_are_rejected():
    run = faulty(refuses(action="navigate_to_pose"))
    log = run((1.0, go(9, reply_to="A")), (1.0, wait(1, B, reply_to="B")))

    assert (False, True) == (log.answer("A").accepted, log.answer("B").accepted)


def test_a_count_limits_the_rejected_goals():
    run = faulty(refuses(count=2))
    log = run(*[(at, go(9, f"{int(at):032x}", reply_to=at)) for at in (1.0, 2.0, 3.0)])

    assert [False, False, True] == [log.answer(at).accepted for at in (1.0, 2.0, 3.0)]
    assert [2.0] == ended(log)


def test_a_running_goal_continues():
    log = faulty(refuses(at=1.0))((0.0, go(9)))

    assert (8.0, "SUCCEEDED") == log.changes(A)[-1]


def test_an_invalid_goal_is_rejected_for_its_own_reason():
    """It does not count as rejected by the fault."""
    run = faulty(refuses(count=1))
    log = run((1.0, SendGoal("wall_e", "pickup", None, A, "A")), (2.0, go(9, B, reply_to="B")))

    assert ("invalid_goal", "busy") == (log.answer("A").reason, log.answer("B").reason)


@pytest.mark.parametrize("delay", [0.0, 2.5])
def test_a_goal_is_aborted_after_the_delay(delay):
    log = faulty(fails(delay=delay))((1.0, go(9)), until=9.0)

    assert [(1.0, "ACCEPTED"), (1.0, "EXECUTING"), (1.0 + delay, "ABORTED")] == log.changes(A)
    assert (1.0 + delay, 2.0) == log.simulator.robots["wall_e"].pose().point
    assert ("fault goals_aborted_1", "goals_aborted") == (log.result(A).error_msg, log.goal_changes(A)[-1].cause)


def test_the_result_has_the_given_code_and_text():
    log = faulty(fails(action="navigate_to_pose", error_code=208, error_msg="no valid path found"))((1.0, go(9)))

    assert (208, "no valid path found") == (log.result(A).error_code, log.result(A).error_msg)


def test_without_a_code_the_result_has_the_code_for_unknown_errors():
    log = faulty(fails(count=None))((1.0, go(9)), (2.0, wait(1, B)))

    assert (9000, 740) == (log.result(A).error_code, log.result(B).error_code)


def test_an_aborted_pickup_leaves_the_item():
    run = faulty({**fails(action="pickup", error_code=-4), "robot": "eve"})
    log = run((1.0, send("pickup", A, "eve", target_name="parcel")))

    assert (-4, None) == (log.result(A).error_code.val, log.simulator.items["parcel"].carrier)


@pytest.mark.parametrize(("keys", "aborted"), [({}, 1), ({"count": 2}, 2)])
def test_a_count_limits_the_aborted_goals(keys, aborted):
    log = faulty(fails(**keys))((1.0, wait(1)), (2.0, wait(1, B)), (3.0, wait(1, C)))

    statuses = [log.changes(goal)[-1][1] for goal in (A, B, C)]
    assert ["ABORTED"] * aborted + ["SUCCEEDED"] * (3 - aborted) == statuses
    assert [float(aborted)] == ended(log)


@pytest.mark.parametrize(
    ("commands", "status"),
    [([(0.0, wait(1))], "SUCCEEDED"), ([(0.0, wait(9)), (1.0, CancelGoal("wall_e", "wait", A))], "CANCELED")],
)
def test_a_goal_that_ends_before_the_delay_does_not_count(commands, status):
    log = faulty(fails(delay=2.0))(*commands, (2.0, wait(9, B)))

    assert [(1.0, status), (4.0, "ABORTED")] == [log.changes(goal)[-1] for goal in (A, B)]


@pytest.mark.parametrize(
    ("keys", "end"),
    [({"at": 1.0, "delay": 3.0}, 3.0), ({"when": {"goal": "executing", "action": "wait", "after": 4.0}}, 4.0)],
)
def test_a_delay_counts_from_the_beginning_of_a_running_goal(keys, end):
    log = faulty(fails(**keys))((0.0, wait(9)))

    assert (end, "ABORTED") == log.changes(A)[-1]


def test_goals_of_other_robots_and_actions_are_not_aborted():
    run = faulty(fails(action="wait", count=None))
    log = run((1.0, go(5)), (1.0, go(5, B, "eve")))

    assert ["SUCCEEDED", "SUCCEEDED"] == [log.changes(goal)[-1][1] for goal in (A, B)]


def test_an_instant_goal_is_aborted():
    goal = ComputePathToPose.Goal.model_validate({"goal": {"pose": {"position": {"x": 9.0, "y": 2.0}}}})
    log = faulty(fails(action="compute_path_to_pose", error_code=207))(
        (1.0, SendGoal("wall_e", "compute_path_to_pose", goal, A))
    )

    assert ((1.0, "ABORTED"), 207) == (log.changes(A)[-1], log.result(A).error_code)


def test_an_ended_fault_aborts_no_running_goal():
    """Its timers are canceled, so the simulation does not wait for them."""
    log = faulty(fails(delay=5.0, until=2.0))((0.0, wait(3)))

    assert ((3.0, "SUCCEEDED"), 3.0) == (log.changes(A)[-1], log.simulator.now)


def test_the_robot_takes_goals_afterwards():
    log = faulty(fails(delay=1.0))((0.0, go(9)), (2.0, go(9, B)))

    assert (9.0, "SUCCEEDED") == log.changes(B)[-1]


@pytest.mark.parametrize(
    ("fault", "why"),
    [
        (fails(action="docking"), "action: no action 'docking'; "),
        (fails(robot="cart", action="pickup"), "action: cart does not serve pickup: it has no claw"),
        (fails(action="simulate_steps"), "action: no action 'simulate_steps'; there are "),
        (fails(action="wait", error_code=999), "wait has no error code 999; there are 740 UNKNOWN, 741 TIMEOUT"),
        (fails(error_code=740), "each action has its own codes; give action for 740, or leave error_code out"),
        (fails(count=0), "count: must be at least 1, got 0"),
        (refuses(reason="tired"), "reason: expected 'busy' or 'not_ready', got 'tired'"),
        (refuses(action="navigate"), "action: no action 'navigate'; did you mean 'navigate_to_pose'?"),
    ],
)
def test_invalid_faults_are_rejected(fault, why):
    with pytest.raises(WorldError) as raised:
        world_of({**SMALL_WORLD, "faults": [fault]}, "small")

    assert why in str(raised.value)
