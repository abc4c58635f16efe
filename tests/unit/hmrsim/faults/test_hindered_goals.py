"""Faults of goals: some are rejected, others end ABORTED, although the robot could execute them."""

from __future__ import annotations

import json

import pytest

from hmrsim.errors import WorldError
from hmrsim.interfaces.moveit_msgs import Pickup
from hmrsim.interfaces.nav2_msgs import ComputePathToPose, NavigateToPose, Wait
from hmrsim.protocol.commands import CancelGoal, SendGoal
from hmrsim.trace.replay import replay
from hmrsim.world_checks.loading import world_of
from tests.simulation import SMALL_WORLD, simulate

A, B, C = "a" * 32, "b" * 32, "c" * 32


def go(x, goal_id=A, robot="wall_e", reply_to=None):
    """Return the command that sends a robot along the lanes."""
    goal = NavigateToPose.Goal.model_validate({"pose": {"pose": {"position": {"x": float(x), "y": 2.0}}}})
    return SendGoal(robot, "navigate_to_pose", goal, goal_id, reply_to)


def rest(seconds, goal_id=A, reply_to=None):
    """Return the command that lets a robot wait."""
    return SendGoal("wall_e", "wait", Wait.Goal.model_validate({"time": {"sec": seconds}}), goal_id, reply_to)


def faulty(*faults, **settings):
    """Return a simulation of the small world with faults."""
    return simulate({**SMALL_WORLD, "faults": [*faults]}, **settings)


def refuses(**keys):
    """Return a fault by which goals of a robot are rejected."""
    return {"type": "goals_rejected", "robot": "wall_e", **keys}


def fails(**keys):
    """Return a fault by which goals of a robot are aborted."""
    return {"type": "goals_aborted", "robot": "wall_e", **keys}


def ended(log):
    """Return when faults ended."""
    return [time for time, _ in log.happened("fault_ended")]


# --- rejected --------------------------------------------------------------------------------------------------------


def test_goals_are_rejected_while_it_lasts():
    """As by a robot that is busy with something else."""
    run = faulty(refuses(until=2.0))
    log = run((1.0, go(9, reply_to="A")), (2.0, go(9, B, reply_to="B")))

    answer = log.answer("A")
    assert (False, "busy", "wall_e is busy with something else") == (answer.accepted, answer.reason, answer.error_msg)
    assert log.answer("B").accepted


def test_goals_are_rejected_for_the_reason_that_is_stated():
    """Clients tell them apart."""
    log = faulty(refuses(reason="not_ready"))((1.0, go(9, reply_to="A")))

    assert ("not_ready", "wall_e is not ready") == (log.answer("A").reason, log.answer("A").error_msg)


def test_goals_of_one_action_are_rejected():
    """Others are not."""
    run = faulty(refuses(action="navigate_to_pose"))
    log = run((1.0, go(9, reply_to="A")), (1.0, rest(1, B, reply_to="B")))

    assert (False, True) == (log.answer("A").accepted, log.answer("B").accepted)


def test_so_many_goals_are_rejected():
    """Then the fault is over, in the instant of the last one."""
    run = faulty(refuses(count=2))
    log = run(*[(at, go(9, f"{int(at):032x}", reply_to=at)) for at in (1.0, 2.0, 3.0)])

    assert [False, False, True] == [log.answer(at).accepted for at in (1.0, 2.0, 3.0)]
    assert [2.0] == ended(log)


def test_a_goal_that_runs_goes_on():
    """Only new ones are rejected."""
    log = faulty(refuses(at=1.0))((0.0, go(9)))

    assert (8.0, "SUCCEEDED") == log.changes(A)[-1]


def test_an_invalid_goal_is_rejected_for_its_own_reason():
    """And does not count."""
    run = faulty(refuses(count=1))
    log = run((1.0, SendGoal("wall_e", "pickup", None, A, "A")), (2.0, go(9, B, reply_to="B")))

    assert ("invalid_goal", "busy") == (log.answer("A").reason, log.answer("B").reason)


# --- aborted ---------------------------------------------------------------------------------------------------------


def test_a_goal_is_aborted_at_the_instant_at_which_it_begins():
    """It is accepted, executes, and ends; the robot stays where it is."""
    log = faulty(fails())((1.0, go(9)), until=3.0)

    assert [(1.0, "ACCEPTED"), (1.0, "EXECUTING"), (1.0, "ABORTED")] == log.changes(A)
    assert ([1.0, 2.0], "fault goals_aborted_1") == (
        [*log.simulator.robots["wall_e"].pose().point],
        log.result(A).error_msg,
    )


def test_a_goal_is_aborted_some_time_after_it_began():
    """The robot stops where it is by then."""
    log = faulty(fails(delay=2.5))((1.0, go(9)), until=9.0)

    assert ((3.5, "ABORTED"), (3.5, 2.0)) == (log.changes(A)[-1], tuple(log.simulator.robots["wall_e"].pose().point))


def test_its_cause_is_the_kind_of_the_fault():
    """Programs know by it that it was no fault of theirs."""
    log = faulty(fails())((1.0, go(9)))

    assert "goals_aborted" == log.goal_changes(A)[-1].cause


def test_its_result_has_the_code_and_the_text_that_are_stated():
    """Those of Nav2's server."""
    log = faulty(fails(action="navigate_to_pose", error_code=208, error_msg="no valid path found"))((1.0, go(9)))

    assert (208, "no valid path found") == (log.result(A).error_code, log.result(A).error_msg)


def test_without_a_code_its_result_has_that_for_unknown_errors():
    """Each action's own."""
    log = faulty(fails(count=None))((1.0, go(9)), (2.0, rest(1, B)))

    assert (9000, 740) == (log.result(A).error_code, log.result(B).error_code)


def test_a_gripper_that_gives_up_holds_nothing():
    """The item is where it was."""
    run = faulty({**fails(action="pickup", error_code=-4), "robot": "eve"})
    log = run((1.0, SendGoal("eve", "pickup", Pickup.Goal(target_name="parcel"), A)))

    assert (-4, None) == (log.result(A).error_code.val, log.simulator.items["parcel"].carrier)


def test_one_goal_is_aborted():
    """Unless it says how many; then the fault is over."""
    log = faulty(fails())((1.0, rest(1)), (2.0, rest(1, B)))

    assert [(1.0, "ABORTED"), (3.0, "SUCCEEDED")] == [log.changes(goal)[-1] for goal in (A, B)]
    assert [1.0] == ended(log)


def test_so_many_goals_are_aborted():
    """The later ones succeed."""
    log = faulty(fails(count=2))((1.0, rest(1)), (2.0, rest(1, B)), (3.0, rest(1, C)))

    assert ["ABORTED", "ABORTED", "SUCCEEDED"] == [log.changes(goal)[-1][1] for goal in (A, B, C)]


def test_a_goal_that_ends_by_itself_before_does_not_count():
    """The next one that lasts long enough does."""
    log = faulty(fails(delay=2.0))((0.0, rest(1)), (2.0, rest(9, B)))

    assert [(1.0, "SUCCEEDED"), (4.0, "ABORTED")] == [log.changes(goal)[-1] for goal in (A, B)]


def test_a_goal_that_is_canceled_before_does_not_count():
    """Likewise."""
    run = faulty(fails(delay=2.0))
    log = run((0.0, rest(9)), (1.0, CancelGoal("wall_e", "wait", A)), (2.0, rest(9, B)))

    assert [(1.0, "CANCELED"), (4.0, "ABORTED")] == [log.changes(goal)[-1] for goal in (A, B)]


def test_a_goal_that_executes_already_is_aborted_in_time():
    """Its seconds count from its own beginning."""
    log = faulty(fails(at=1.0, delay=3.0))((0.0, rest(9)))

    assert (3.0, "ABORTED") == log.changes(A)[-1]


def test_a_goal_that_has_executed_for_longer_is_aborted_at_once():
    """As one that was anchored in it."""
    when = {"goal": "executing", "action": "wait", "after": 4.0}
    log = faulty(fails(when=when))((1.0, rest(9)))

    assert (5.0, "ABORTED") == log.changes(A)[-1]


def test_goals_of_other_robots_and_actions_are_not_aborted():
    """Only what is stated."""
    run = faulty(fails(action="wait", count=None))
    log = run((1.0, go(5)), (1.0, go(5, B, "eve")))

    assert ["SUCCEEDED", "SUCCEEDED"] == [log.changes(goal)[-1][1] for goal in (A, B)]


def test_a_goal_that_takes_no_time_is_aborted_too():
    """Such as the planning of a path."""
    goal = ComputePathToPose.Goal.model_validate({"goal": {"pose": {"position": {"x": 9.0, "y": 2.0}}}})
    log = faulty(fails(action="compute_path_to_pose", error_code=207))(
        (1.0, SendGoal("wall_e", "compute_path_to_pose", goal, A))
    )

    assert ((1.0, "ABORTED"), 207) == (log.changes(A)[-1], log.result(A).error_code)


def test_a_fault_that_is_over_aborts_no_goal_that_runs():
    """Its timers are gone, and no time passes for them."""
    log = faulty(fails(delay=5.0, until=2.0))((0.0, rest(3)))

    assert ((3.0, "SUCCEEDED"), 3.0) == (log.changes(A)[-1], log.simulator.now)


def test_the_robot_takes_goals_afterwards():
    """It is in order."""
    log = faulty(fails(delay=1.0))((0.0, go(9)), (2.0, go(9, B)))

    assert (9.0, "SUCCEEDED") == log.changes(B)[-1]


def test_a_replay_has_the_same_ends():
    """Those of the file, and of what was injected."""
    run = faulty(fails(delay=1.0, count=3), refuses(at=4.0, count=1), traced=True)
    run((0.0, go(9)), (2.0, go(9, B)), (4.0, go(5, C)), until=5.0)
    run.ask("inject_fault", {"type": "goals_aborted", "settings": json.dumps({"robot": "eve", "action": "wait"})})
    run((5.0, go(1, "d" * 32)), (9.0, go(1, "e" * 32)))
    outcome = replay(run.lines())

    assert (True, None) == (outcome.complete, outcome.difference)


# --- mistakes --------------------------------------------------------------------------------------------------------


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
def test_what_makes_no_sense_is_told(fault, why):
    """With what would do."""
    with pytest.raises(WorldError) as raised:
        world_of({**SMALL_WORLD, "faults": [fault]}, "small")

    assert why in str(raised.value)
