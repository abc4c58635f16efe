"""The blocking interface to robots."""

from __future__ import annotations

import asyncio
import math

import pytest

from hmrsim.actions import registry
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.moveit_msgs import Pickup
from hmrsim.interfaces.nav2_msgs import Wait
from hmrsim.protocol.goal import GoalStatus
from hmrsim.testing import simulation
from hmrsim_zenoh import (
    AsyncClient,
    Client,
    Commander,
    GoalFailed,
    GoalRejectedError,
    GoalTimeout,
    NotCharging,
    RequestError,
    SimulatorGone,
)


@pytest.mark.parametrize("action", ["wait", registry()["wait"]])
@pytest.mark.parametrize("goal", [{"time": {"sec": 3}}, Wait.Goal.model_validate({"time": {"sec": 3}})])
def test_a_goal_of_any_action(action, goal):
    """The action may be given by name, and the goal as a message or as plain values."""
    with simulation("cafe") as run:
        result = run.commander("mocha").do(action, goal)

        assert isinstance(result, Wait.Result)
        assert 3.0 == run.now


def test_a_pose_by_name():
    with simulation("cafe") as run:
        run.commander("mocha").do("navigate_to_pose", {"pose": "counter"})

        assert ["counter"] == run.visited("mocha")
        with pytest.raises(ValueError, match=r"goal: pose: no place 'conter'; did you mean 'counter'"):
            run.commander("mocha").do("navigate_to_pose", {"pose": "conter"})


def test_a_goal_of_any_action_with_asyncio():
    told = []

    async def play(client):
        async with AsyncClient(client) as robots:
            await robots.robot("mocha").do("wait", {"time": {"sec": 3}}, on_feedback=told.append)

    with simulation("cafe") as run:
        asyncio.run(play(run.client))

        assert 3.0 == run.now
    assert all(isinstance(one, Wait.Feedback) for one in told)
    assert told


@pytest.mark.parametrize(
    ("action", "error"),
    [
        ("wipe", "no action 'wipe' is installed; there are "),
        ("wiat", r"no action 'wiat' is installed; did you mean 'wait'\?"),
    ],
)
def test_an_action_that_is_not_installed(action, error):
    """The call raises an error before anything is sent."""
    with simulation("cafe") as run, pytest.raises(ValueError, match=error):
        run.commander("mocha").do(action, {})


def test_a_goal_with_other_fields():
    """The simulator's error names the field."""
    with simulation("cafe") as run, pytest.raises(RequestError, match=r"goal\.tiem"):
        run.commander("mocha").do("wait", {"tiem": {}})


def test_a_goal_that_fails():
    with simulation("cafe") as run, pytest.raises(GoalFailed, match="mocha: pickup ended ABORTED: no item 'tea'"):
        run.commander("mocha").do("pickup", {"target_name": "tea"})


def test_a_charge_is_waited_for():
    """Simulated time stops at that charge."""
    with simulation("cafe", changes={"robots.mocha.components.battery.initial_charge": 1000}) as run:
        mocha = run.commander("mocha")
        assert 0.333 == round(mocha.battery().percentage, 3)
        mocha.dock("charger_1")
        state = mocha.wait_until_charged(0.8)

        assert 0.8 == round(state.percentage, 6)
        assert 20 < run.now < 30


def test_a_charge_that_does_not_come():
    with simulation("cafe") as run:
        chai = run.commander("chai")
        chai.wait(6)
        with pytest.raises(NotCharging, match="'chai' does not charge"):
            chai.wait_until_charged(1.0)
        with pytest.raises(ValueError, match=r"-0.1 is not a share of a capacity; expected a number from 0 to 1"):
            chai.wait_until_charged(-0.1)
        with pytest.raises(RequestError, match="no robot 'wally'; there are: mocha, latte, chai"):
            run.commander("wally").battery()


def test_feedback_of_a_goal_that_has_ended_wakes_nobody():
    """Time no longer stops for feedback once the goal of a listener has ended."""
    with simulation("cafe") as run:
        client = run.client.action_client("mocha", registry()["wait"])
        heard = []
        client.send_goal(Wait.Goal(time=Duration(sec=3)), on_feedback=heard.append).result()
        before = len(heard)
        client.send_goal(Wait.Goal(time=Duration(sec=3))).result()

        assert before > 0
        assert frozenset({"result"}) == run.client.lockstep._kinds()
        assert before == len(heard)


class TestGoals:
    """The goals of a commander and their ends, on a fake connection."""

    @pytest.fixture(params=["realtime", "lockstep"])
    def wall_e(self, connection, request):
        with Client(session=connection, clock=request.param, grace=5.0) as client:
            yield Commander(client, "wall_e")

    @pytest.mark.parametrize(
        ("call", "fields"),
        [
            (lambda robot: robot.pickup("medicine"), {"target_name": "medicine"}),
            (lambda robot: robot.place("medicine"), {"attached_object_name": "medicine"}),
            (lambda robot: robot.wait(1.5), {"time": Duration(sec=1, nanosec=500_000_000)}),
        ],
    )
    def test_a_call_sends_a_goal(self, connection, wall_e, call, fields):
        connection.robot = lambda goal: goal.succeed()
        call(wall_e)

        assert fields == {name: getattr(connection.goals[0].goal, name) for name in fields}

    def test_a_pose_has_a_quaternion(self, connection, wall_e):
        connection.robot = lambda goal: goal.succeed()
        wall_e.go_to_pose(512, 215, yaw=math.pi)

        pose = connection.goals[0].goal.pose.pose
        assert (512.0, 215.0) == (pose.position.x, pose.position.y)
        assert (1.0, pytest.approx(0.0)) == (pose.orientation.z, pose.orientation.w)

    @pytest.mark.parametrize(
        ("call", "end", "text"),
        [
            (
                lambda robot: robot.wait(1),
                lambda goal: goal.abort(208, "no route"),
                r"wait ended ABORTED: no route \(208\)",
            ),
            (
                lambda robot: robot.pickup("tea"),
                lambda goal: goal.end(GoalStatus.ABORTED, Pickup.Result(error_code={"val": -1, "message": "too far"})),
                r"pickup ended ABORTED: too far \(-1\)",
            ),
            (
                lambda robot: robot.wait(1),
                lambda goal: goal.end(GoalStatus.CANCELED, cause="preempted"),
                "wait ended CANCELED: error code 0",
            ),
        ],
    )
    def test_a_goal_that_fails_has_the_message_of_its_result(self, connection, wall_e, call, end, text):
        """Nav2 has error_code and error_msg, MoveIt error_code.val and error_code.message."""
        connection.robot = end

        with pytest.raises(GoalFailed, match=f"wall_e: {text}") as caught:
            call(wall_e)
        assert ("preempted" if "CANCELED" in text else "") == caught.value.cause

    def test_a_rejected_goal_raises_the_rejection(self, connection, wall_e):
        connection.robot = lambda goal: goal.reject("not_ready")

        with pytest.raises(GoalRejectedError, match="not_ready"):
            wall_e.wait(1)

    @pytest.mark.parametrize("interrupt", [KeyboardInterrupt, GoalTimeout])
    def test_a_goal_whose_wait_ends_early_is_canceled(self, connection, wall_e, interrupt, monkeypatch):
        """The robot must not continue when the script has given up."""

        def accept(goal):
            goal.accept()
            goal.when_canceled = goal.end_canceled

        def wait(*_, **__):
            monkeypatch.undo()
            raise interrupt

        connection.robot = accept
        monkeypatch.setattr("hmrsim_zenoh.client.goal_handle.GoalHandle.result", wait)

        with pytest.raises(interrupt):
            wall_e.wait(60)
        assert connection.goals[0].canceled

    def test_a_simulator_that_leaves_fails_the_call(self, connection, wall_e):
        def leave(goal):
            goal.accept()
            connection.vanish()
            connection.wall = 60.0
            connection.run_later()
            connection.run_later()

        connection.robot = leave

        with pytest.raises(SimulatorGone):
            wall_e.wait(60)


class TestTasks:
    """The goals of tasks, in lockstep on a fake connection."""

    def played(self, connection, play):
        """Return what a coroutine function makes of robot wall_e."""

        async def main():
            with Client(session=connection, clock="lockstep") as client:
                async with AsyncClient(client) as robots:
                    return await play(robots.robot("wall_e"))

        return asyncio.run(main())

    def test_goals_of_several_tasks_go_with_one_advance(self, connection):
        connection.robot = lambda goal: goal.succeed()

        async def play(robot):
            return await asyncio.gather(robot.wait(1), robot.wait(2))

        assert [Wait.Result()] * 2 == self.played(connection, play)
        assert [2] == [len(each.commands) for each in connection.requests if hasattr(each, "commands")]

    @pytest.mark.parametrize(
        ("end", "error"),
        [
            (lambda goal: goal.abort(740, "tired"), GoalFailed),
            (lambda goal: goal.reject("busy"), GoalRejectedError),
            (lambda goal: goal.fail(RequestError("no such action")), RequestError),
        ],
    )
    def test_the_end_of_a_goal_is_raised_in_its_task(self, connection, end, error):
        connection.robot = end

        async def play(robot):
            with pytest.raises(error):
                await robot.wait(1)

        self.played(connection, play)

    def test_a_canceled_task_cancels_its_goal_and_waits_for_its_end(self, connection):
        ends = []

        def accept(goal):
            goal.accept()
            goal.when_canceled = lambda: (ends.append("canceled"), goal.end_canceled())

        connection.robot = accept

        async def play(robot):
            with pytest.raises(TimeoutError):
                await asyncio.wait_for(robot.wait(1000), 2.0)
            return [*ends]

        assert ["canceled"] == self.played(connection, play)
