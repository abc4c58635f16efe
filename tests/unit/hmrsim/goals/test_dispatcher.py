"""The life of goals, by the rules of ROS 2 and Nav2."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.actions import Action, Codes
from hmrsim.actions import registry as all_actions
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.geometry_msgs import PoseStamped
from hmrsim.interfaces.nav2_msgs import ComputePathToPose, NavigateToPose, Wait
from hmrsim.protocol.commands import CancelGoal, ForgetResult, GetResult, SendGoal
from hmrsim.protocol.goal import GoalStatus, Refused
from hmrsim.protocol.outputs import GoalChanged
from hmrsim.protocol.topics import Topic
from hmrsim.simulation.simulator import Simulator
from hmrsim.world.model import World
from tests.profiles import examples
from tests.simulation import SMALL_WORLD, A, B, C, D, Log, at, send, simulate

NANO = 1_000_000_000
ALL = "0" * 32
FORGOTTEN = [(20.0, ForgetResult("wall_e", "navigate_to_pose", A))]
SLOW_CLAW = {
    "items": {"letter": {"at": [0, 0]}, "parcel": {"at": [0, 0]}},
    "robots": {"wall_e": {"type": "fetcher", "at": [0, 0], "components": {"claw": {"handling_time": 5}}}},
}
_SAMPLES = ("FeedbackSent", "Sampled")


def go(x=9.0, y=2.0, *, goal_id=A, robot="wall_e", frame=""):
    return send("navigate_to_pose", goal_id, robot, pose={**at(x, y), "header": {"frame_id": frame}})


def wait(seconds=10, *, goal_id=A, robot="wall_e"):
    return send("wait", goal_id, robot, time={"sec": seconds})


def grab(item="letter", *, goal_id=A, robot="wall_e"):
    return send("pickup", goal_id, robot, target_name=item)


def cancel(goal_id=ALL, stamp=0, *, action="wait", robot="wall_e"):
    return CancelGoal(robot, action, goal_id, stamp, "cancel")


class TestAccept:
    def test_an_accepted_goal_executes_at_once(self, run):
        log = run((1.5, go()))

        assert [(1.5, "ACCEPTED"), (1.5, "EXECUTING"), (9.5, "SUCCEEDED")] == log.changes(A)

    @pytest.mark.parametrize(("at", "stamp"), [(1.5, 1_500_000_000), (0.0, 1)])
    def test_the_stamp_is_the_simulated_time_but_never_zero(self, run, at, stamp):
        """ROS reads a zero stamp as unset."""
        assert stamp == run((at, go())).answer(A).stamp

    def test_the_answer_precedes_the_status(self, run):
        log = run((0.0, go()))

        assert ["Answered", "EventStamped", "GoalChanged"] == [type(event).__name__ for _, event in log.events[:3]]

    def test_a_goal_without_id_gets_one_from_the_seed(self, make_run):
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
    def test_a_rejection_has_reason_code_and_text(self, run, command, reason, code, text):
        log = run((0.0, command))

        answer = log.answer(command.reply_to)
        assert (False, reason, code) == (answer.accepted, answer.reason, answer.error_code)
        assert text in answer.error_msg
        assert [] == log.changes(command.goal_id)

    def test_the_map_frame_is_accepted(self, run):
        assert run((0.0, go(frame="map"))).answer(A).accepted

    def test_a_robot_with_an_external_planner_is_not_ready(self, make_run):
        run = make_run({"robots": {"wall_e": {"at": [0, 0], "planner": "external"}}})

        assert "not_ready" == run((0.0, go())).answer(A).reason

    def test_a_rejected_goal_has_no_result(self, run):
        log = run((0.0, go(frame="odom")), (0.0, GetResult("wall_e", "navigate_to_pose", A, "result")))

        assert GoalStatus.UNKNOWN == log.answer("result").status


class TestDuplicate:
    @pytest.mark.parametrize(
        ("between", "at", "status", "stamp"),
        [
            ([], 1.0, GoalStatus.EXECUTING, 1),
            ([], 20.0, GoalStatus.SUCCEEDED, 1),
            (FORGOTTEN, 21.0, GoalStatus.SUCCEEDED, 21 * NANO),
        ],
        ids=["active", "ended", "forgotten"],
    )
    def test_a_duplicate_is_rejected_with_the_status_of_its_goal(self, run, between, at, status, stamp):
        log = run((0.0, go()), *between, (at, go()._replace(reply_to="again")))

        answer = log.answer("again")
        assert (False, "duplicate_goal_id") == (answer.accepted, answer.reason)
        assert (status, stamp) == (answer.status, answer.stamp)
        assert 3 == len(log.changes(A))

    def test_the_ids_of_the_latest_goals_are_kept(self, run, monkeypatch):
        """Memory must not grow with each goal."""
        monkeypatch.setattr("hmrsim.goals.servers.MAX_FORGOTTEN", 2)
        ids = [f"{number:032x}" for number in (1, 2, 3)]
        sent = [(float(at), wait(1)._replace(goal_id=goal_id)) for at, goal_id in enumerate(ids)]
        forgotten = [(10.0, ForgetResult("wall_e", "wait", goal_id)) for goal_id in ids]
        again = [(11.0, wait(1)._replace(goal_id=goal_id, reply_to=goal_id)) for goal_id in reversed(ids)]
        log = run(*sent, *forgotten, *again)

        assert [False, False, True] == [log.answer(goal_id).accepted for goal_id in reversed(ids)]

    def test_another_action_may_use_the_same_id(self, run):
        log = run((0.0, wait(1)), (5.0, go()._replace(reply_to="other")))

        assert log.answer("other").accepted


class TestPreempt:
    def test_a_new_goal_preempts_the_old_one_at_once(self, run):
        log = run((0.0, go()), (1.0, go(5.0, 2.0, goal_id=B)))

        changes = [(e.goal_id, e.status.name) for t, e in log.events if isinstance(e, GoalChanged) and t == 1.0]
        assert [(A, "ABORTED"), (B, "ACCEPTED"), (B, "EXECUTING")] == changes
        assert (9000, f"preempted by goal {B}") == (log.result(A).error_code, log.result(A).error_msg)
        assert (4.0, "SUCCEEDED") == log.changes(B)[-1]

    def test_the_new_goal_begins_where_the_robot_is(self, run):
        log = run((0.0, go()), (1.0, go(1.0, 2.0, goal_id=B)))

        assert (2.0, "SUCCEEDED") == log.changes(B)[-1]

    def test_wait_holds_the_base(self, run):
        log = run((0.0, wait(10)), (1.0, go(goal_id=B)))

        assert 740 == log.result(A).error_code

    def test_three_goals_at_one_instant_leave_the_last(self, run):
        log = run((0.0, go()), (0.0, go(goal_id=B)), (0.0, go(goal_id=C)))

        assert ["ABORTED", "ABORTED", "SUCCEEDED"] == [log.changes(i)[-1][1] for i in (A, B, C)]

    def test_goals_of_other_robots_continue(self, run):
        log = run((0.0, go()), (0.0, go(5.0, 2.0, goal_id=B, robot="eve")))

        assert ["SUCCEEDED", "SUCCEEDED"] == [log.changes(i)[-1][1] for i in (A, B)]

    def test_a_pickup_does_not_preempt(self, run):
        log = run((0.0, go()), (1.0, grab(goal_id=B)))

        assert ["ACCEPTED", "EXECUTING", "ABORTED"] == [status for _, status in log.changes(B)]
        assert -17 == log.result(B).error_code.val
        assert f"wall_e is busy with navigate_to_pose goal {A}" == log.result(B).error_code.message
        assert (8.0, "SUCCEEDED") == log.changes(A)[-1]

    def test_a_drive_preempts_a_pickup(self, make_run):
        run = make_run(SLOW_CLAW)
        log = run((0.0, grab()), (1.0, wait(1, goal_id=B)))

        assert (1.0, "ABORTED") == log.changes(A)[-1]
        assert -7 == log.result(A).error_code.val
        assert run.simulator.items["letter"].carrier is None

    def test_a_pickup_does_not_preempt_a_pickup(self, make_run):
        log = make_run(SLOW_CLAW)((0.0, grab()), (1.0, grab("parcel", goal_id=B)))

        assert [(1.0, "ABORTED"), (5.0, "SUCCEEDED")] == [log.changes(i)[-1] for i in (B, A)]


class TestCancel:
    def test_a_canceled_goal_ends_at_once(self, run):
        log = run((0.0, go()), (1.5, cancel(A, action="navigate_to_pose")))

        assert [(1.5, "CANCELING"), (1.5, "CANCELED")] == log.changes(A)[2:]
        assert (0, "canceled") == (log.result(A).error_code, log.result(A).error_msg)

    def test_the_robot_stays_where_it_was(self, run):
        run((0.0, go()), (1.5, cancel(A, action="navigate_to_pose")), (9.0, cancel()))

        assert (2.5, 2.0) == run.simulator.robots["wall_e"].pose().point

    def test_the_answer_lists_what_is_canceling(self, run):
        answer = run((1.0, wait()), (2.0, cancel(A))).answer("cancel")

        assert (0, [(A, NANO)]) == (answer.return_code, [(g.goal_id, g.stamp) for g in answer.goals_canceling])

    @pytest.mark.parametrize(
        ("before", "goal_id", "code"),
        [
            ([(0.0, wait())], B, 2),
            ([(0.0, wait(1))], A, 3),
            ([(0.0, wait(1)), (2.0, ForgetResult("wall_e", "wait", A))], A, 2),
        ],
        ids=["unknown", "ended", "forgotten"],
    )
    def test_a_goal_that_is_not_running_has_rcl_s_code(self, run, before, goal_id, code):
        answer = run(*before, (3.0, cancel(goal_id))).answer("cancel")

        assert (code, ()) == (answer.return_code, answer.goals_canceling)

    def test_all_zero_cancels_all(self, run):
        log = run((0.0, wait()), (1.0, cancel()), (2.0, cancel()._replace(reply_to="none")))

        assert [A] == [g.goal_id for g in log.answer("cancel").goals_canceling]
        assert (0, ()) == (log.answer("none").return_code, log.answer("none").goals_canceling)

    @pytest.mark.parametrize(
        ("goal_id", "stamp", "canceling"),
        [(ALL, 2 * NANO, [A, B]), (ALL, NANO // 2, []), (C, NANO, [A, C]), (D, NANO // 2, [])],
    )
    def test_a_stamp_cancels_goals_up_to_it_and_the_id(self, make_slow, goal_id, stamp, canceling):
        goals = [(time, slow(i)) for time, i in ((1.0, A), (2.0, B), (3.0, C))]
        answer = make_slow()(*goals, (4.0, cancel(goal_id, stamp, action="slow")), until=5.0).answer("cancel")

        assert (0, canceling) == (answer.return_code, [goal.goal_id for goal in answer.goals_canceling])

    def test_a_goal_can_be_canceled_at_the_instant_of_its_acceptance(self, run):
        log = run((1.0, go()), (1.0, cancel(A, action="navigate_to_pose")))

        assert ["ACCEPTED", "EXECUTING", "CANCELING", "CANCELED"] == [status for _, status in log.changes(A)]
        assert (1.0, 2.0) == run.simulator.robots["wall_e"].pose().point

    def test_a_cancel_for_an_unknown_robot_is_rejected(self, run):
        assert isinstance(run((0.0, cancel(robot="nobody"))).answer("cancel"), Refused)


def slow(goal_id):
    return SendGoal("wall_e", "slow", Wait.Goal(time=Duration(sec=100)), goal_id, goal_id)


@pytest.fixture
def make_slow():
    """Return the function that makes simulations whose *slow* goals run in parallel."""
    waiting = all_actions()["wait"]

    def make():
        return simulate(actions={"slow": replace(waiting, name="slow", holds_base=False)})

    return make


class TestResult:
    def test_requests_are_held_until_the_goal_ends(self, run):
        ask = [(1.0, GetResult("wall_e", "navigate_to_pose", A, who)) for who in ("one", "two")]
        log = run((0.0, go()), *ask)

        kinds = [
            type(event).__name__ for time, event in log.events if time == 8.0 and type(event).__name__ != "Sampled"
        ]
        assert ["FeedbackSent", "GoalChanged", "StatusChanged", "Answered", "Answered"] == kinds
        assert GoalStatus.SUCCEEDED == log.answer("one").status == log.answer("two").status

    def test_an_ended_goal_answers_each_request_at_once(self, run):
        ask = [(20.0, GetResult("wall_e", "navigate_to_pose", A, who)) for who in ("one", "two")]

        log = run((0.0, go()), *ask)

        assert NavigateToPose.Result() == log.answer("one").result == log.answer("two").result

    def test_an_unknown_goal_has_status_0_and_default_result(self, run):
        log = run((0.0, GetResult("wall_e", "navigate_to_pose", B, "result")))

        assert GoalStatus.UNKNOWN == log.answer("result").status
        assert NavigateToPose.Result() == log.answer("result").result

    def test_a_forgotten_result_has_status_0(self, run):
        log = run((0.0, go()), *FORGOTTEN, (20.0, GetResult("wall_e", "navigate_to_pose", A, "result")))

        assert GoalStatus.UNKNOWN == log.answer("result").status

    def test_only_ended_goals_are_forgotten(self, run):
        log = run((0.0, go()), (1.0, ForgetResult("wall_e", "navigate_to_pose", A)))

        assert (8.0, "SUCCEEDED") == log.changes(A)[-1]

    def test_a_robot_keeps_a_limited_number_of_results(self, make_run):
        run = make_run(keep_results=2)
        asks = [(9.0, GetResult("wall_e", "wait", i, i + "?")) for i in (A, B, C)]
        log = run((0.0, wait(1)), (2.0, wait(1, goal_id=B)), (4.0, wait(1, goal_id=C)), *asks)

        assert [0, 4, 4] == [log.answer(i + "?").status for i in (A, B, C)]

    def test_results_that_are_kept_take_little_memory(self, run, collect):
        """Only the poses of the last path are messages; older results are text."""
        goal = ComputePathToPose.Goal(goal=go().goal.pose)
        ids = [f"{number:032x}" for number in range(1, 101)]
        log = run(*((1.0, SendGoal("wall_e", "compute_path_to_pose", goal, each, each)) for each in ids))
        poses = len(log.result(ids[0]).path.poses)
        log.events.clear()

        kept = len(collect(PoseStamped))
        log = run((100.0, GetResult("wall_e", "compute_path_to_pose", ids[0], "again")))
        assert poses == len(log.answer("again").result.path.poses) > 1
        assert kept < 10 * poses

    def test_a_result_that_can_not_be_read_as_json_is_kept(self, make_run):
        """A plug-in's type may hold values that its validation rejects."""

        def rubbish(robot, _goal, _report):
            yield from robot.hold(1.0)
            return Wait.Result.model_construct(error_msg=5)

        run = make_run(actions={"wait": replace(all_actions()["wait"], process=rubbish)})
        log = run((0.0, wait()), (2.0, wait(goal_id=B)), (4.0, GetResult("wall_e", "wait", A, "again")))

        assert log.result(A) is log.answer("again").result

    def test_a_result_of_an_unknown_robot_is_rejected(self, run):
        answer = run((0.0, GetResult("nobody", "wait", A, "result"))).answer("result")

        assert "robot" == answer.field
        assert "nobody" == answer.value
        assert "no robot 'nobody'; there are: cart, eve, wall_e" == answer.message


class TestResultTo:
    def test_the_result_follows_the_last_status(self, run):
        log = run((0.0, wait(1)._replace(result_to="result")))

        kinds = [type(event).__name__ for time, event in log.events if time == 1.0]
        assert ["GoalChanged", "StatusChanged", "Answered"] == [kind for kind in kinds if kind not in _SAMPLES]
        assert GoalStatus.SUCCEEDED == log.answer("result").status

    def test_the_acceptance_precedes_the_result_of_an_instant_goal(self, run):
        log = run((0.0, wait(0)._replace(reply_to="all", result_to="all")))

        accepted, ended = log.answers("all")
        assert (True, GoalStatus.SUCCEEDED) == (accepted.accepted, ended.status)

    @pytest.mark.parametrize("command", [go(frame="odom"), go(robot="nobody"), go(goal_id="no id")])
    def test_a_rejected_goal_gets_no_result(self, run, command):
        log = run((0.0, command._replace(result_to="result")))

        assert not log.answer(command.reply_to).accepted
        assert [] == log.answers("result")

    def test_a_duplicate_gets_no_result(self, run):
        """The goal with the id belongs to another request."""
        log = run((0.0, wait()), (1.0, wait()._replace(reply_to="again", result_to="result")))

        assert "duplicate_goal_id" == log.answer("again").reason
        assert [] == log.answers("result")

    def test_a_preempted_goal_gets_a_result(self, run):
        log = run((0.0, go()._replace(result_to="result")), (1.0, wait(goal_id=B)), until=2.0)

        ended = log.answer("result")
        assert (GoalStatus.ABORTED, f"preempted by goal {B}") == (ended.status, ended.result.error_msg)


class TestStatus:
    def test_it_lists_all_kept_goals_in_order_of_acceptance(self, run):
        run((0.0, wait(1)), (2.0, wait(1, goal_id=B)), until=2.5)

        goals = run.simulator.dispatcher.status("wall_e", "wait").goals
        assert [(A, 4), (B, 2)] == [(goal.goal_id, goal.status) for goal in goals]


class TestEnd:
    def test_stopping_aborts_running_goals(self, run):
        log = run((0.0, go()), (0.0, GetResult("wall_e", "navigate_to_pose", A, "result")), until=1.0)
        run.simulator.stop("the simulator was stopped")

        robot = run.simulator.robots["wall_e"]
        assert GoalStatus.ABORTED == log.answer("result").status
        assert (9000, "the simulator was stopped") == (log.result(A).error_code, log.result(A).error_msg)
        assert ((2.0, 2.0), 0.0) == (robot.pose().point, robot.motion.progress().length)

    def test_a_bug_in_an_action_aborts_its_goal_before_it_is_raised(self, make_run):
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
        def stubborn(robot, _goal, _report):
            with suppress(BaseException):
                yield from robot.hold(5.0)
            return Wait.Result()

        run = make_run(actions={"wait": replace(all_actions()["wait"], process=stubborn)})
        log = run((0.0, wait()), (1.0, cancel(A)))

        assert (1.0, "CANCELED") == log.changes(A)[-1]


class TestFeedback:
    def test_feedback_comes_ten_times_per_second_and_at_the_end(self, run):
        log = run((1.0, go(1.35, 2.0)))

        assert [1.1, 1.2, 1.3, 1.35] == pytest.approx([time for time, _ in log.feedback(A)])
        assert [0.25, 0.15, 0.05, 0.0] == pytest.approx([f.distance_remaining for _, f in log.feedback(A)])
        assert 0.0 == log.feedback(A)[-1][1].distance_remaining

    def test_the_last_feedback_precedes_the_terminal_status(self, run):
        log = run((0.0, go()), (1.05, cancel(A, action="navigate_to_pose")), until=5.0)

        kinds = [type(event).__name__ for time, event in log.events if time == 1.05]
        assert kinds.index("FeedbackSent") < kinds.index("GoalChanged", kinds.index("Answered"))
        assert 1.05 == log.feedback(A)[-1][0]

    def test_a_goal_that_ends_before_its_process_begins_is_not_sampled(self, make_run):
        run = make_run(topics=frozenset({Topic.FEEDBACK}))
        run((1.0, go()), (1.0, cancel(A, action="navigate_to_pose")), until=5.0)

        assert math.inf == run.simulator.telemetry.next_due

    def test_no_feedback_is_computed_without_a_subscriber(self, make_run):
        asked = []

        def counting(robot, _goal, report):
            report.sample(lambda: asked.append(robot.now))
            yield from robot.hold(5.0)
            return Wait.Result()

        run = make_run(topics=frozenset(), actions={"wait": replace(all_actions()["wait"], process=counting)})
        run((0.0, wait()))

        assert [] == asked

    def test_the_rate_is_a_setting(self, make_run):
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
def test_any_commands_give_each_goal_one_terminal_status(commands, stopped):
    """Transitions are legal, each goal has one answer and one result, and no base stays held."""
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
    assert all(isinstance(action, Action) and isinstance(action.codes, Codes) for action in all_actions().values())


def test_a_sink_that_is_attached_later_receives_the_changes_of_goals():
    """Changes are not emitted as long as nothing processes them."""
    simulator, log = Simulator(World.model_validate(SMALL_WORLD)), Log()
    simulator.submit(wait(1, goal_id=A))
    simulator.advance(2.0)
    log.simulator = simulator

    simulator.attach(log)
    simulator.submit(wait(1, goal_id=B))
    simulator.advance(4.0)

    assert ([], ["ACCEPTED", "EXECUTING", "SUCCEEDED"]) == (
        log.changes(A),
        [status for _, status in log.changes(B)],
    )
