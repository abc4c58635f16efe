"""The life of goals: accepted, rejected, preempted, canceled, kept; the rules of ROS 2 and of Nav2."""

from __future__ import annotations

import gc
import math
from contextlib import suppress
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.actions import Action, Codes
from hmrsim.actions import registry as all_actions
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.geometry_msgs import Point, Pose, PoseStamped
from hmrsim.interfaces.moveit_msgs import Pickup
from hmrsim.interfaces.nav2_msgs import ComputePathToPose, NavigateToPose, Wait
from hmrsim.interfaces.std_msgs import Header
from hmrsim.protocol.answers import Refused
from hmrsim.protocol.commands import CancelGoal, ForgetResult, GetResult, SendGoal
from hmrsim.protocol.goal import GoalStatus
from hmrsim.protocol.outputs import GoalChanged
from hmrsim.protocol.topics import Topic
from tests.profiles import examples
from tests.simulation import simulate

A, B, C, D = (letter * 32 for letter in "abcd")
NANO = 1_000_000_000
_SAMPLES = ("FeedbackSent", "Sampled")


def go(x=9.0, y=2.0, *, goal_id=A, robot="wall_e", frame=""):
    """Return the command to drive to a point; answered to its goal id."""
    target = PoseStamped(header=Header(frame_id=frame), pose=Pose(position=Point(x=x, y=y)))
    return SendGoal(robot, "navigate_to_pose", NavigateToPose.Goal(pose=target), goal_id, goal_id)


def wait(seconds=10, *, goal_id=A, robot="wall_e"):
    """Return the command to wait."""
    return SendGoal(robot, "wait", Wait.Goal(time=Duration(sec=seconds)), goal_id, goal_id)


def grab(item="letter", *, goal_id=A, robot="wall_e"):
    """Return the command to pick up an item."""
    return SendGoal(robot, "pickup", Pickup.Goal(target_name=item), goal_id, goal_id)


def cancel(goal_id="0" * 32, stamp=0, *, action="wait", robot="wall_e"):
    """Return the command to cancel; answered to 'cancel'."""
    return CancelGoal(robot, action, goal_id, stamp, "cancel")


def _alive(kind):
    """Return the number of objects of a class."""
    gc.collect()
    return sum(isinstance(each, kind) for each in gc.get_objects())


class TestAccept:
    """send_goal, as semantics and contract have it."""

    def test_an_accepted_goal_executes_at_once(self, run):
        """Its statuses are ACCEPTED and EXECUTING at the instant of acceptance."""
        log = run((1.5, go()))

        assert [(1.5, "ACCEPTED"), (1.5, "EXECUTING"), (9.5, "SUCCEEDED")] == log.changes(A)

    def test_the_stamp_is_the_simulated_time(self, run):
        """The answer says when it was accepted."""
        log = run((1.5, go()))

        assert 1_500_000_000 == log.answer(A).stamp

    def test_the_stamp_is_never_zero(self, run):
        """At time zero it is one nanosecond: ROS reads zero as unset."""
        log = run((0.0, go()))

        assert 1 == log.answer(A).stamp

    def test_the_answer_comes_before_the_status(self, run):
        """The client learns of acceptance first; a subscriber learns of the goal before its status."""
        log = run((0.0, go()))

        assert ["Answered", "EventStamped", "GoalChanged"] == [type(event).__name__ for _, event in log.events[:3]]

    def test_a_goal_without_id_gets_one_from_the_seed(self, make_run):
        """Two runs of one seed make the same ids, another seed makes others."""
        ids = [
            make_run(seed=seed)((0.0, go()._replace(goal_id=None, reply_to="x"))).answer("x").goal_id
            for seed in (1, 1, 2)
        ]

        assert ids[0] == ids[1] != ids[2]
        assert 32 == len(ids[0])

    @pytest.mark.parametrize(
        ("command", "reason", "code", "text"),
        [
            (go(goal_id="0" * 32), "invalid_goal_id", 1, "zero"),
            (go(goal_id="no id"), "invalid_goal_id", 1, "'no id' is not a UUID"),
            (go(robot="nobody"), "unknown_robot", 1, "no robot 'nobody'; there are: cart, eve, wall_e"),
            (
                grab(robot="cart"),
                "unknown_action",
                99999,
                "cart has no action 'pickup', which needs the component 'claw'; it has: ",
            ),
            (SendGoal("wall_e", "fly", None, A, A), "unknown_action", 1, "wall_e has no action 'fly'"),
            (go(frame="odom"), "invalid_goal", 1, "unknown frame_id 'odom'; use 'map'"),
        ],
    )
    def test_a_goal_that_is_not_accepted_says_why(self, run, command, reason, code, text):
        """The answer carries the reason, a code, and a text with the value; no goal comes to be."""
        log = run((0.0, command))

        answer = log.answer(command.reply_to)
        assert (False, reason, code) == (answer.accepted, answer.reason, answer.error_code)
        assert text in answer.error_msg
        assert [] == log.changes(command.goal_id)

    def test_a_frame_map_is_accepted(self, run):
        """The one frame that there is may be named."""
        assert run((0.0, go(frame="map"))).answer(A).accepted

    def test_a_robot_with_an_external_planner_is_not_ready(self, make_run):
        """No planner has been announced."""
        run = make_run({"robots": {"wall_e": {"at": [0, 0], "planner": "external"}}})

        assert "not_ready" == run((0.0, go())).answer(A).reason

    def test_a_rejected_goal_has_no_result(self, run):
        """Its get_result is answered with status 0."""
        log = run((0.0, go(frame="odom")), (0.0, GetResult("wall_e", "navigate_to_pose", A, "result")))

        assert GoalStatus.UNKNOWN == log.answer("result").status


class TestDuplicate:
    """An id is used once in a run."""

    def test_an_active_goal_s_id_is_refused_with_its_status(self, run):
        """The resend is not executed, and learns that the goal is on its way."""
        log = run((0.0, go()), (1.0, go()._replace(reply_to="again")), until=2.0)

        answer = log.answer("again")
        assert (False, "duplicate_goal_id", GoalStatus.EXECUTING, 1) == (
            answer.accepted,
            answer.reason,
            answer.status,
            answer.stamp,
        )

    def test_an_ended_goal_s_id_is_refused_with_its_status(self, run):
        """A late resend learns how the goal ended."""
        log = run((0.0, go()), (20.0, go()._replace(reply_to="again")))

        assert GoalStatus.SUCCEEDED == log.answer("again").status

    def test_a_forgotten_goal_s_id_is_refused_too(self, run):
        """The result is gone, but the goal is not executed again."""
        forget = ForgetResult("wall_e", "navigate_to_pose", A)
        log = run((0.0, go()), (20.0, forget), (21.0, go()._replace(reply_to="again")))

        assert ("duplicate_goal_id", GoalStatus.SUCCEEDED) == (log.answer("again").reason, log.answer("again").status)
        assert 3 == len(log.changes(A))

    def test_the_ids_of_the_latest_goals_are_kept(self, run, monkeypatch):
        """Of three whose results are gone two are refused; memory does not grow with each goal."""
        monkeypatch.setattr("hmrsim.goals.servers.MAX_FORGOTTEN", 2)
        ids = [f"{number:032x}" for number in (1, 2, 3)]
        sent = [(float(at), wait(1)._replace(goal_id=goal_id)) for at, goal_id in enumerate(ids)]
        forgotten = [(10.0, ForgetResult("wall_e", "wait", goal_id)) for goal_id in ids]
        again = [(11.0, wait(1)._replace(goal_id=goal_id, reply_to=goal_id)) for goal_id in reversed(ids)]
        log = run(*sent, *forgotten, *again)

        assert [False, False, True] == [log.answer(goal_id).accepted for goal_id in reversed(ids)]

    def test_another_action_may_use_the_same_id(self, run):
        """Each action of each robot is a server of its own, as in ROS."""
        log = run((0.0, wait(1)), (5.0, go()._replace(reply_to="other")))

        assert log.answer("other").accepted


class TestPreempt:
    """One goal at a time holds a robot's base."""

    def test_a_new_goal_preempts_the_old_at_its_instant(self, run):
        """The old one is ABORTED with its action's UNKNOWN code and names the new one."""
        log = run((0.0, go()), (1.0, go(5.0, 2.0, goal_id=B)))

        assert [(0.0, "ACCEPTED"), (0.0, "EXECUTING"), (1.0, "ABORTED")] == log.changes(A)
        assert (9000, f"preempted by goal {B}") == (log.result(A).error_code, log.result(A).error_msg)
        assert (4.0, "SUCCEEDED") == log.changes(B)[-1]

    def test_no_two_goals_ever_execute_on_one_base(self, run):
        """In the order of events the old one has ended before the new one is there."""
        log = run((0.0, go()), (1.0, go(5.0, 2.0, goal_id=B)))

        changes = [(e.goal_id, e.status.name) for t, e in log.events if isinstance(e, GoalChanged) and t == 1.0]
        assert [(A, "ABORTED"), (B, "ACCEPTED"), (B, "EXECUTING")] == changes

    def test_the_new_goal_begins_where_the_robot_is(self, run):
        """After 1 s at 1 m/s it stands at (2, 2), 1 s from home."""
        log = run((0.0, go()), (1.0, go(1.0, 2.0, goal_id=B)))

        assert (2.0, "SUCCEEDED") == log.changes(B)[-1]

    def test_wait_holds_the_base_too(self, run):
        """A goal to drive preempts one to wait, whose code is Wait's."""
        log = run((0.0, wait(10)), (1.0, go(goal_id=B)))

        assert 740 == log.result(A).error_code

    def test_three_goals_at_one_instant_leave_the_last(self, run):
        """Each preempts the one before."""
        log = run((0.0, go()), (0.0, go(goal_id=B)), (0.0, go(goal_id=C)))

        assert ["ABORTED", "ABORTED", "SUCCEEDED"] == [log.changes(i)[-1][1] for i in (A, B, C)]

    def test_other_robots_are_left_alone(self, run):
        """Each robot has a base of its own."""
        log = run((0.0, go()), (0.0, go(5.0, 2.0, goal_id=B, robot="eve")))

        assert ["SUCCEEDED", "SUCCEEDED"] == [log.changes(i)[-1][1] for i in (A, B)]

    def test_a_pickup_does_not_preempt(self, run):
        """It is accepted and ends ABORTED with INVALID_ROBOT_STATE; the drive goes on."""
        log = run((0.0, go()), (1.0, grab(goal_id=B)))

        assert ["ACCEPTED", "EXECUTING", "ABORTED"] == [status for _, status in log.changes(B)]
        assert -17 == log.result(B).error_code.val
        assert f"wall_e is busy with navigate_to_pose goal {A}" == log.result(B).error_code.message
        assert (8.0, "SUCCEEDED") == log.changes(A)[-1]

    def test_a_drive_preempts_a_pickup(self, make_run):
        """While the claw is handling, the base is held; the pickup's code is PREEMPTED, and the item stays."""
        world = {
            "items": {"letter": {"at": [0, 0]}},
            "robots": {"wall_e": {"type": "fetcher", "at": [0, 0], "components": {"claw": {"handling_time": 5}}}},
        }
        run = make_run(world)
        log = run((0.0, grab()), (1.0, wait(1, goal_id=B)))

        assert (1.0, "ABORTED") == log.changes(A)[-1]
        assert -7 == log.result(A).error_code.val
        assert run.simulator.items["letter"].carrier is None

    def test_a_pickup_does_not_preempt_a_pickup(self, make_run):
        """The second finds the base held."""
        world = {
            "items": {"letter": {"at": [0, 0]}, "parcel": {"at": [0, 0]}},
            "robots": {"wall_e": {"type": "fetcher", "at": [0, 0], "components": {"claw": {"handling_time": 5}}}},
        }
        log = make_run(world)((0.0, grab()), (1.0, grab("parcel", goal_id=B)))

        assert [(1.0, "ABORTED"), (5.0, "SUCCEEDED")] == [log.changes(i)[-1] for i in (B, A)]


class TestCancel:
    """cancel_goal: rcl's selection, rcl's codes."""

    def test_a_canceled_goal_ends_at_once(self, run):
        """A goal canceled at 1.5 s is CANCELED at 1.5 s, not at the next waypoint."""
        log = run((0.0, go()), (1.5, cancel(A, action="navigate_to_pose")))

        assert [(1.5, "CANCELING"), (1.5, "CANCELED")] == log.changes(A)[2:]
        assert (0, "canceled") == (log.result(A).error_code, log.result(A).error_msg)

    def test_the_robot_stays_where_it_was(self, run):
        """1.5 m from home."""
        run((0.0, go()), (1.5, cancel(A, action="navigate_to_pose")), (9.0, cancel()))

        assert (2.5, 2.0) == run.simulator.robots["wall_e"].pose().point

    def test_the_answer_lists_what_is_canceling(self, run):
        """Code 0, the id and the stamp of acceptance."""
        answer = run((1.0, wait()), (2.0, cancel(A))).answer("cancel")

        assert (0, [(A, NANO)]) == (answer.return_code, [(g.goal_id, g.stamp) for g in answer.goals_canceling])

    def test_an_unknown_id_is_code_2(self, run):
        """ERROR_UNKNOWN_GOAL_ID, empty list."""
        answer = run((0.0, wait()), (1.0, cancel(B))).answer("cancel")

        assert (2, ()) == (answer.return_code, answer.goals_canceling)

    def test_an_ended_goal_is_code_3(self, run):
        """ERROR_GOAL_TERMINATED, empty list."""
        answer = run((0.0, wait(1)), (2.0, cancel(A))).answer("cancel")

        assert (3, ()) == (answer.return_code, answer.goals_canceling)

    def test_a_forgotten_goal_is_code_2(self, run):
        """It is not known any more, as in rcl."""
        log = run((0.0, wait(1)), (2.0, ForgetResult("wall_e", "wait", A)), (3.0, cancel(A)))

        assert 2 == log.answer("cancel").return_code

    def test_all_zero_cancels_all(self, run):
        """And is code 0 with an empty list when there is nothing to cancel."""
        log = run((0.0, wait()), (1.0, cancel()), (2.0, cancel()._replace(reply_to="none")))

        assert [A] == [g.goal_id for g in log.answer("cancel").goals_canceling]
        assert (0, ()) == (log.answer("none").return_code, log.answer("none").goals_canceling)

    def test_a_stamp_cancels_what_was_accepted_at_or_before(self, make_slow):
        """Goals at 1, 2 and 3 s: a stamp of 2 s takes two of them."""
        run = make_slow()
        log = run(
            *[(t, slow(i)) for t, i in ((1.0, A), (2.0, B), (3.0, C))],
            (4.0, cancel(stamp=2 * NANO, action="slow")),
            until=5.0,
        )

        assert [A, B] == [g.goal_id for g in log.answer("cancel").goals_canceling]

    def test_a_stamp_before_all_cancels_none(self, make_slow):
        """Code 0 with an empty list."""
        log = make_slow()((2.0, slow(A)), (3.0, cancel(stamp=NANO, action="slow")), until=4.0)

        assert (0, ()) == (log.answer("cancel").return_code, log.answer("cancel").goals_canceling)

    def test_id_and_stamp_cancel_the_union(self, make_slow):
        """The id, and all up to the stamp."""
        run = make_slow()
        log = run(
            *[(t, slow(i)) for t, i in ((1.0, A), (2.0, B), (3.0, C))], (4.0, cancel(C, NANO, action="slow")), until=5.0
        )

        assert [A, C] == [g.goal_id for g in log.answer("cancel").goals_canceling]

    def test_an_unknown_id_with_a_stamp_is_code_0(self, make_slow):
        """Also when the stamp selects nothing."""
        log = make_slow()((2.0, slow(A)), (3.0, cancel(D, NANO, action="slow")), until=4.0)

        assert (0, ()) == (log.answer("cancel").return_code, log.answer("cancel").goals_canceling)

    def test_a_goal_can_be_canceled_at_the_instant_of_its_acceptance(self, run):
        """It ends CANCELED, and the robot has not moved."""
        log = run((1.0, go()), (1.0, cancel(A, action="navigate_to_pose")))

        assert ["ACCEPTED", "EXECUTING", "CANCELING", "CANCELED"] == [status for _, status in log.changes(A)]
        assert (1.0, 2.0) == run.simulator.robots["wall_e"].pose().point

    def test_an_unknown_robot_is_refused(self, run):
        """There is nothing that a return code could say of it."""
        assert isinstance(run((0.0, cancel(robot="nobody"))).answer("cancel"), Refused)


def slow(goal_id):
    """Return the command for a goal of the action *slow*."""
    return SendGoal("wall_e", "slow", Wait.Goal(time=Duration(sec=100)), goal_id, goal_id)


@pytest.fixture
def make_slow():
    """Return what makes simulations with an action that does not hold the base, so that goals run side by side."""
    waiting = all_actions()["wait"]

    def make():
        return simulate(actions={"slow": replace(waiting, name="slow", holds_base=False)})

    return make


class TestResult:
    """get_result: held, repeated, kept, forgotten."""

    def test_it_is_held_until_the_goal_ends_for_everyone_who_asks(self, run):
        """Two clients ask; both get it at the end, after the status."""
        ask = [(1.0, GetResult("wall_e", "navigate_to_pose", A, who)) for who in ("one", "two")]
        log = run((0.0, go()), *ask)

        kinds = [
            type(event).__name__ for time, event in log.events if time == 8.0 and type(event).__name__ != "Sampled"
        ]
        assert ["FeedbackSent", "GoalChanged", "StatusChanged", "Answered", "Answered"] == kinds
        assert GoalStatus.SUCCEEDED == log.answer("one").status == log.answer("two").status

    def test_an_ended_goal_answers_at_once_any_number_of_times(self, run):
        """The result is kept."""
        ask = [(20.0, GetResult("wall_e", "navigate_to_pose", A, who)) for who in ("one", "two")]

        log = run((0.0, go()), *ask)

        assert NavigateToPose.Result() == log.answer("one").result == log.answer("two").result

    def test_an_unknown_goal_is_status_0_with_the_type_s_defaults(self, run):
        """Never an error, never a wait."""
        log = run((0.0, GetResult("wall_e", "navigate_to_pose", B, "result")))

        assert (GoalStatus.UNKNOWN, NavigateToPose.Result()) == (
            log.answer("result").status,
            log.answer("result").result,
        )

    def test_a_forgotten_result_is_status_0(self, run):
        """As if the goal had never been."""
        forget = ForgetResult("wall_e", "navigate_to_pose", A)
        log = run((0.0, go()), (20.0, forget), (20.0, GetResult("wall_e", "navigate_to_pose", A, "result")))

        assert GoalStatus.UNKNOWN == log.answer("result").status

    def test_only_ended_goals_are_forgotten(self, run):
        """Expiry can't take a goal that runs."""
        log = run((0.0, go()), (1.0, ForgetResult("wall_e", "navigate_to_pose", A)))

        assert (8.0, "SUCCEEDED") == log.changes(A)[-1]

    def test_a_robot_remembers_so_many_results(self, make_run):
        """With two to be kept, the first of three is gone."""
        run = make_run(keep_results=2)
        asks = [(9.0, GetResult("wall_e", "wait", i, i + "?")) for i in (A, B, C)]
        log = run((0.0, wait(1)), (2.0, wait(1, goal_id=B)), (4.0, wait(1, goal_id=C)), *asks)

        assert [0, 4, 4] == [log.answer(i + "?").status for i in (A, B, C)]

    def test_results_that_are_kept_take_little_memory(self, run):
        """Paths of one hundred goals: the poses of the last one are messages, all others are text."""
        goal = ComputePathToPose.Goal(goal=go().goal.pose)
        ids = [f"{number:032x}" for number in range(1, 101)]
        before = _alive(PoseStamped)
        log = run(*((1.0, SendGoal("wall_e", "compute_path_to_pose", goal, each, each)) for each in ids))
        poses = len(log.result(ids[0]).path.poses)
        log.events.clear()

        kept = _alive(PoseStamped) - before
        log = run((100.0, GetResult("wall_e", "compute_path_to_pose", ids[0], "again")))
        assert poses == len(log.answer("again").result.path.poses) > 1
        assert kept < 10 * poses

    def test_a_result_that_can_not_be_read_as_json_is_kept(self, make_run):
        """A plug-in's type may hold what its own validation refuses."""

        def rubbish(robot, _goal, _report):
            yield from robot.hold(1.0)
            return Wait.Result.model_construct(error_msg=5)

        run = make_run(actions={"wait": replace(all_actions()["wait"], process=rubbish)})
        log = run((0.0, wait()), (2.0, wait(goal_id=B)), (4.0, GetResult("wall_e", "wait", A, "again")))

        assert log.result(A) is log.answer("again").result

    def test_a_result_of_an_unknown_robot_is_refused(self, run):
        """The text names those that there are."""
        answer = run((0.0, GetResult("nobody", "wait", A, "result"))).answer("result")

        assert ("robot", "nobody", "no robot 'nobody'; there are: cart, eve, wall_e") == (
            answer.field,
            answer.value,
            answer.message,
        )


class TestResultTo:
    """A goal whose command asks for its result, too."""

    def test_it_gets_the_result_at_the_end_after_the_status(self, run):
        """As if it had been asked for right behind the goal."""
        log = run((0.0, wait(1)._replace(result_to="result")))

        kinds = [type(event).__name__ for time, event in log.events if time == 1.0]
        assert ["GoalChanged", "StatusChanged", "Answered"] == [kind for kind in kinds if kind not in _SAMPLES]
        assert GoalStatus.SUCCEEDED == log.answer("result").status

    def test_the_acceptance_comes_first_although_the_goal_ends_at_once(self, run):
        """Also when one and the same object is handed back with both."""
        log = run((0.0, wait(0)._replace(reply_to="all", result_to="all")))

        accepted, ended = log.answers("all")
        assert (True, GoalStatus.SUCCEEDED) == (accepted.accepted, ended.status)

    @pytest.mark.parametrize("command", [go(frame="odom"), go(robot="nobody"), go(goal_id="no id")])
    def test_a_rejected_goal_has_none(self, run, command):
        """The rejection is all."""
        log = run((0.0, command._replace(result_to="result")))

        assert not log.answer(command.reply_to).accepted
        assert [] == log.answers("result")

    def test_a_duplicate_has_none(self, run):
        """The goal that has the id is another request's; `GetResult` gets its result."""
        log = run((0.0, wait()), (1.0, wait()._replace(reply_to="again", result_to="result")))

        assert "duplicate_goal_id" == log.answer("again").reason
        assert [] == log.answers("result")

    def test_a_preempted_goal_has_one(self, run):
        """It is told by whom."""
        log = run((0.0, go()._replace(result_to="result")), (1.0, wait(goal_id=B)), until=2.0)

        ended = log.answer("result")
        assert (GoalStatus.ABORTED, f"preempted by goal {B}") == (ended.status, ended.result.error_msg)


class TestStatus:
    """The status list."""

    def test_it_lists_all_kept_goals_in_order_of_acceptance(self, run):
        """An ended goal stays in it."""
        run((0.0, wait(1)), (2.0, wait(1, goal_id=B)), until=2.5)

        goals = run.simulator.dispatcher.status("wall_e", "wait").goals
        assert [(A, 4), (B, 2)] == [(goal.goal_id, goal.status) for goal in goals]


class TestEnd:
    """Whatever happens, an accepted goal gets exactly one terminal status."""

    def test_stopping_aborts_what_runs(self, run):
        """The result gives the reason, and a client that waits for it is answered."""
        log = run((0.0, go()), (0.0, GetResult("wall_e", "navigate_to_pose", A, "result")), until=1.0)
        run.simulator.stop("the simulator was stopped")

        assert GoalStatus.ABORTED == log.answer("result").status
        assert (9000, "the simulator was stopped") == (log.result(A).error_code, log.result(A).error_msg)

    def test_a_robot_that_is_stopped_stands(self, run):
        """It is where it was, and nothing remains to be driven."""
        run((0.0, go()), until=1.0)
        run.simulator.stop()

        assert ((2.0, 2.0), 0.0) == (
            run.simulator.robots["wall_e"].pose().point,
            run.simulator.robots["wall_e"].motion.progress().length,
        )

    def test_a_bug_in_an_action_aborts_its_goal_and_leaves_the_run(self, make_run):
        """ABORTED is sent first, then the exception comes out."""

        def broken(robot, _goal, _report):
            yield from robot.hold(1.0)
            raise ZeroDivisionError("oops")

        waiting = all_actions()["wait"]
        run = make_run(actions={"wait": replace(waiting, process=broken)})

        with pytest.raises(ZeroDivisionError):
            run((0.0, wait()))
        assert (1.0, "ABORTED") == run.log.changes(A)[-1]
        assert "bug in wait: ZeroDivisionError: oops" == run.log.result(A).error_msg

    def test_an_action_that_ignores_an_interrupt_does_not_change_the_verdict(self, make_run):
        """CANCELED stays CANCELED."""

        def stubborn(robot, _goal, _report):
            with suppress(BaseException):
                yield from robot.hold(5.0)
            return Wait.Result()

        run = make_run(actions={"wait": replace(all_actions()["wait"], process=stubborn)})
        log = run((0.0, wait()), (1.0, cancel(A)))

        assert (1.0, "CANCELED") == log.changes(A)[-1]


class TestFeedback:
    """Feedback: sampled in simulated time, and once more at the end."""

    def test_it_comes_ten_times_a_second_and_at_the_end(self, run):
        """A drive of 0.35 s: three samples and the last."""
        log = run((1.0, go(1.35, 2.0)))

        assert [1.1, 1.2, 1.3, 1.35] == pytest.approx([time for time, _ in log.feedback(A)])
        assert [0.25, 0.15, 0.05, 0.0] == pytest.approx([f.distance_remaining for _, f in log.feedback(A)])
        assert 0.0 == log.feedback(A)[-1][1].distance_remaining

    def test_the_last_comes_before_the_terminal_status_and_none_after(self, run):
        """Also of a canceled goal."""
        log = run((0.0, go()), (1.05, cancel(A, action="navigate_to_pose")), until=5.0)

        kinds = [type(event).__name__ for time, event in log.events if time == 1.05]
        assert kinds.index("FeedbackSent") < kinds.index("GoalChanged", kinds.index("Answered"))
        assert 1.05 == log.feedback(A)[-1][0]

    def test_a_goal_that_ends_before_its_process_begins_is_not_sampled(self, make_run):
        """Canceled at the instant of its acceptance: nothing of it is due later."""
        run = make_run(topics=frozenset({Topic.FEEDBACK}))
        run((1.0, go()), (1.0, cancel(A, action="navigate_to_pose")), until=5.0)

        assert math.inf == run.simulator.telemetry.next_due

    def test_no_feedback_is_made_without_a_subscriber(self, make_run):
        """The action is not even asked."""
        asked = []

        def counting(robot, _goal, report):
            report.sample(lambda: asked.append(robot.now))
            yield from robot.hold(5.0)
            return Wait.Result()

        run = make_run(topics=frozenset(), actions={"wait": replace(all_actions()["wait"], process=counting)})
        run((0.0, wait()))

        assert [] == asked

    def test_the_rate_is_a_setting(self, make_run):
        """Two a second."""
        log = make_run(feedback_rate=2.0)((0.0, wait(1)))

        assert [0.5, 1.0] == [time for time, _ in log.feedback(A)]


_ROBOTS = ["wall_e", "eve", "cart", "nobody"]
_COMMANDS = st.one_of(
    st.builds(
        lambda robot, x, y: ("go", robot, x, y),
        st.sampled_from(_ROBOTS),
        st.sampled_from([1.0, 3.3, 5.0, 9.0, 15.0, 30.0]),
        st.sampled_from([2.0, 2.5, 5.0]),
    ),
    st.builds(lambda robot, s: ("wait", robot, s), st.sampled_from(_ROBOTS), st.integers(0, 3)),
    st.builds(
        lambda robot, item: ("grab", robot, item),
        st.sampled_from(_ROBOTS),
        st.sampled_from(["letter", "parcel", "ghost"]),
    ),
    st.builds(
        lambda robot, action: ("cancel", robot, action),
        st.sampled_from(_ROBOTS),
        st.sampled_from(["wait", "navigate_to_pose", "pickup"]),
    ),
)


@examples(60)
@given(st.lists(st.tuples(st.floats(0, 4), _COMMANDS), max_size=25), st.booleans())
def test_any_commands_leave_each_accepted_goal_one_terminal_status_and_every_robot_free(commands, stopped):
    """Any commands: transitions are legal, each goal has one end, one answer and one result, and no base is held."""
    run = simulate()
    at = 0.0
    timed = []
    for number, (delay, (kind, robot, *rest)) in enumerate(commands):
        at += delay
        goal_id = f"{number + 1:032x}"
        match kind:
            case "go":
                timed.append((at, go(*rest, goal_id=goal_id, robot=robot)._replace(result_to=goal_id * 2)))
            case "wait":
                timed.append((at, wait(*rest, goal_id=goal_id, robot=robot)._replace(result_to=goal_id * 2)))
            case "grab":
                timed.append((at, grab(*rest, goal_id=goal_id, robot=robot)._replace(result_to=goal_id * 2)))
            case _:
                timed.append((at, cancel(action=rest[0], robot=robot)._replace(reply_to=goal_id)))
    if stopped:
        run(*timed, until=at)
        run.simulator.stop()
    else:
        run(*timed)

    for _, command in timed:
        answer = run.log.answer(command.reply_to)
        if isinstance(command, SendGoal):
            ends = [status for _, status in run.log.changes(command.goal_id) if GoalStatus[status].terminal]
            results = run.log.answers(command.result_to)
            assert (1 if answer.accepted else 0) == len(ends) == len(results)
    assert [None] * 3 == [run.simulator.dispatcher.goal_of(name) for name in run.simulator.robots]


def test_codes_are_data_of_each_action():
    """The dispatcher knows no action by name."""
    assert all(isinstance(action, Action) and isinstance(action.codes, Codes) for action in all_actions().values())
