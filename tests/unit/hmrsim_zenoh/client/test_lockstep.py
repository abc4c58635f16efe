"""A client's part in lockstep, with a simulator that loses replies, forgets, rejects and leaves."""

from __future__ import annotations

import pytest

from hmrsim.actions import registry
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.nav2_msgs import Wait
from hmrsim.protocol.commands import Advance, CancelGoal, SendGoal
from hmrsim.protocol.goal import GoalStatus, made_goal_id
from hmrsim.protocol.outputs import Granted
from hmrsim.protocol.time import Join, Joined, Leave, ReadTime, TimeState
from hmrsim.protocol.topics import Unwatch, Watching
from hmrsim_zenoh.client.connection import Condition, Watched
from hmrsim_zenoh.client.lockstep import check_name
from hmrsim_zenoh.errors import (
    ClientClosed,
    Dropped,
    GoalRejectedError,
    GoalTimeout,
    Idle,
    NameTaken,
    RequestError,
    SimulationEnded,
    SimulatorGone,
)
from tests.fake_connection import HELD, LOST

GOAL = Wait.Goal(time=Duration(sec=2))


def refusal(field, text):
    """Return a simulator's error reply."""
    return RequestError(text, [{"field": field, "message": text, "value": None}])


def state(epoch, now, clock="lockstep"):
    return TimeState(now, clock, 0.0, paused=False, epoch=epoch, participants=(), waiting_for=(), lag=0.0)


@pytest.fixture
def lockstep(connection, lockstep_client):
    """Return a part that has begun in epoch 4, at 2.5 s, after three goals in former lives."""
    connection.script[Join] = [Joined("client", 4, 2.5, 3)]
    connection.script[ReadTime] = [state(4, 2.5)]
    return lockstep_client.lockstep


@pytest.fixture
def wait(lockstep_client):
    return lockstep_client.action_client("wall_e", registry()["wait"])


def of(connection, kind):
    """Return the requests of a kind that came."""
    return [each for each in connection.requests if isinstance(each, kind)]


class TestJoin:
    def test_it_begins_with_epoch_time_and_the_number_of_goals(self, connection, lockstep, wait):
        wait.send_goal(GOAL)
        lockstep.advance(until=3.0)

        assert (["client"], 2.5) == (connection.participants, of(connection, Advance)[0].until - 0.5)
        assert (4, made_goal_id("client", 4)) == (of(connection, Advance)[0].epoch, connection.goals[0].goal_id)

    def test_a_lost_answer_is_given_again(self, connection, lockstep_client):
        connection.script[Join] = [LOST, LOST, Joined("client", 0, 7.0, 0)]

        assert 7.0 == lockstep_client.now
        assert 1 == len({*of(connection, Join)})

    @pytest.mark.parametrize(("field", "error"), [("name", NameTaken), ("", RequestError)])
    def test_a_refused_participant_is_withdrawn(self, connection, lockstep_client, field, error):
        connection.script[Join] = [refusal(field, "no")]
        with pytest.raises(error, match="no"):
            lockstep_client.lockstep  # noqa: B018 - it joins

        assert [] == connection.participants

    def test_a_closed_client_can_not_join(self, lockstep_client):
        lockstep_client.close()

        with pytest.raises(ClientClosed, match="closed"):
            lockstep_client.lockstep  # noqa: B018 - as above

    @pytest.mark.parametrize("name", ["", "7of9", "a/b", "a*", "nurse station"])
    def test_a_name_is_one_chunk_of_a_key(self, name):
        with pytest.raises(ValueError, match="is not a valid participant name"):
            check_name(name)

    def test_leaving_is_announced(self, connection, lockstep):
        lockstep.close()

        assert ([Leave("client")], []) == (of(connection, Leave), connection.participants)


class TestAdvance:
    def test_it_has_all_its_fields_and_commands(self, connection, lockstep, wait):
        goal = wait.send_goal(GOAL)
        goal.cancel()
        lockstep.advance(until=3.0, wake=["result"], report=["feedback"])

        (advance,) = of(connection, Advance)
        assert advance[:5] == ("client", 4, 3.0, frozenset({"result"}), frozenset({"feedback"}))
        assert [SendGoal, CancelGoal] == [type(each) for each in advance.commands]

    def test_a_lost_reply_is_asked_for_again(self, connection, lockstep):
        connection.script[Advance] = [LOST, LOST, Granted(5, 3.0, "until")]
        lockstep.sleep(0.5)

        assert (3, 1, 3.0) == (len(of(connection, Advance)), len({*of(connection, Advance)}), lockstep.now)

    def test_waiting_in_turns_does_not_repeat_the_request(self, connection, lockstep):
        connection.script[Advance] = [HELD]
        before = [lockstep.advance(until=3.0, timeout=0.0) for _ in range(2)]
        connection.calls[-1].answer, connection.calls[-1].ended = Granted(5, 3.0, "until"), True

        assert ([False, False], True) == (before, lockstep.advance(until=9.0))
        assert (1, 3.0) == (len(of(connection, Advance)), lockstep.now)

    def test_a_wrong_epoch_is_corrected_once(self, connection, lockstep):
        """The simulation was reset meanwhile, and the advance is still to be made."""
        connection.script[Advance] = [refusal("epoch", "it is 0"), Granted(1, 2.5, "until")]
        connection.script[ReadTime] = [state(0, 2.5)]
        lockstep.advance(until=2.5)

        assert [4, 0] == [advance.epoch for advance in of(connection, Advance)]

    def test_after_a_reset_the_new_time_comes_first(self, connection, lockstep, wait):
        """Commands for the old time are not applied before the client knows the new one."""
        connection.script[Advance] = [refusal("epoch", "it is 0"), Granted(1, 0.0, "until"), connection.grant]
        connection.script[ReadTime] = [state(0, 0.0)]
        wait.send_goal(GOAL)
        for _ in range(2):
            lockstep.advance(until=3.0)

        assert [(1, 3.0), (0, 0.0), (1, 3.0)] == [
            (len(advance.commands), advance.until) for advance in of(connection, Advance)
        ]

    def test_an_epoch_that_stays_wrong_is_an_error(self, connection, lockstep):
        """Another participant advances under the same name."""
        connection.script[Advance] = [refusal("epoch", "epoch 4 is not the current one, which is 7")]

        with pytest.raises(RequestError, match="not the current one"):
            lockstep.advance()
        assert 2 == len(of(connection, Advance))

    def test_a_dropped_participant_and_its_goals_get_the_reason(self, connection, lockstep, wait):
        connection.script[Advance] = [refusal("participant", "'client' was dropped at 4 s: join again")]
        goal = wait.send_goal(GOAL)

        with pytest.raises(Dropped, match="dropped at 4 s"):
            lockstep.advance()
        with pytest.raises(Dropped, match="dropped at 4 s"):
            goal.result()
        assert lockstep.lost

    def test_an_unreadable_request_fails_its_goals_and_the_next_may_succeed(self, connection, lockstep, wait):
        connection.script[Advance] = [refusal("commands.0.goal", "too large"), connection.grant]
        connection.robot = lambda goal: goal.succeed()
        goals = wait.send_goal(GOAL), None
        with pytest.raises(RequestError, match="too large"):
            goals[0].result()

        assert Wait.Result() == wait.send_goal(GOAL).result()
        assert not lockstep.lost

    def test_a_clock_that_moves_by_itself_ends_the_part(self, connection, lockstep, wait):
        """Goals that were not sent are sent on their own."""
        connection.script[Advance] = [refusal("", "the clock is realtime; set it to lockstep first")]
        connection.script[ReadTime] = [state(6, 9.5, "realtime")]
        goal = wait.send_goal(GOAL)
        lockstep.advance()
        connection.run_later()
        connection.goals[0].succeed()

        assert (True, GoalStatus.SUCCEEDED) == (lockstep.over, goal.status)

    def test_a_wait_ends_when_the_simulator_goes(self, connection, lockstep, wait):
        connection.script[Advance] = [LOST]
        goal = wait.send_goal(GOAL)
        connection.vanish()
        connection.wall = 60.0

        with pytest.raises(SimulatorGone, match="is gone"):
            lockstep.advance()
        with pytest.raises(SimulatorGone):
            goal.result()

    def test_the_end_of_the_run_fails_what_still_waits(self, connection, lockstep, lockstep_client, wait):
        connection.script[Advance] = [Granted(5, 3.0, "end", (LOST,), over="it was to last 3 s")]
        goal = wait.send_goal(GOAL)

        with pytest.raises(SimulationEnded, match="the run is over: it was to last 3 s"):
            goal.result()
        with pytest.raises(SimulationEnded):
            lockstep_client.sleep(1.0)
        assert isinstance(lockstep.ended, SimulationEnded)

    def test_time_that_stands_twice_without_a_command_is_an_error(self, connection, lockstep):
        connection.script[Advance] = [Granted(5, 2.5, "idle"), Granted(6, 2.5, "idle")]
        lockstep.advance()

        with pytest.raises(Idle, match="time can't go on"):
            lockstep.advance()


class TestGoals:
    def test_a_result_comes_with_a_grant(self, connection, wait):
        connection.robot = lambda goal: goal.succeed()
        goal = wait.send_goal(GOAL)

        assert (Wait.Result(), GoalStatus.SUCCEEDED) == (goal.result(), goal.status)

    def test_a_rejection_comes_with_the_first_grant(self, connection, wait):
        connection.robot = lambda goal: goal.reject("busy", "because of orders")

        with pytest.raises(GoalRejectedError, match="busy: because of orders"):
            wait.send_goal(GOAL).wait_accepted()

    def test_waiting_for_the_acceptance_takes_no_time(self, connection, lockstep, wait):
        connection.robot = lambda goal: goal.accept()
        wait.send_goal(GOAL).wait_accepted()

        assert 2.5 == lockstep.now

    def test_a_cancel_goes_right_behind_its_goal(self, connection, wait):
        connection.robot = lambda goal: setattr(goal, "when_canceled", goal.end_canceled)
        goal = wait.send_goal(GOAL)
        goal.cancel()
        goal.result()

        assert (GoalStatus.CANCELED, 1) == (goal.status, len(of(connection, Advance)))

    def test_a_timeout_in_simulated_seconds_stops_there(self, connection, lockstep, wait):
        connection.robot = lambda goal: goal.accept()
        connection.now = 2.5
        goal = wait.send_goal(GOAL)

        with pytest.raises(GoalTimeout, match="after 15 simulated s; it goes on"):
            goal.result(sim_timeout=15.0)
        assert 17.5 == lockstep.now

    def test_feedback_wakes_the_client_while_a_goal_wants_it(self, connection, wait):
        seen = []
        connection.robot = lambda goal: (goal.accept(), goal.feed(time_left=Duration(sec=1)), goal.succeed())
        wait.send_goal(GOAL, on_feedback=seen.append).result()
        wait.send_goal(GOAL).result()

        assert [frozenset({"result", "feedback"}), frozenset({"result"})] == [
            advance.wake for advance in of(connection, Advance)
        ]
        assert [Wait.Feedback(time_left=Duration(sec=1))] == seen

    def test_leaving_cancels_what_was_to_be_canceled(self, connection, lockstep, wait):
        connection.robot = lambda goal: goal.accept()
        goal = wait.send_goal(GOAL)
        goal.wait_accepted()
        goal.cancel()
        connection.script[Advance] = [HELD]
        connection.goals[0].cancel()
        lockstep.close()

        assert connection.goals[0].canceled

    def test_leaving_fails_goals_that_were_not_sent(self, connection, lockstep, wait):
        goal = wait.send_goal(GOAL)
        lockstep.close()

        with pytest.raises(RequestError, match="closed before the goal could be sent"):
            goal.result()
        assert [] == connection.goals


class TestConditions:
    LOW = Condition("eve/battery_state", [("/percentage", "<", 0.3)])

    def test_a_wait_ends_when_one_is_met_and_withdraws_the_others(self, connection, lockstep):
        other = Condition("eve/odom")
        connection.script[Advance] = [
            Granted(5, 3.0, "event", (Watching(True), Watching(True)), met=("1",)),
            Granted(6, 3.0, "until", (LOST,)),
        ]
        met = lockstep.wait_for(self.LOW, other)
        lockstep.advance(until=3.0)

        assert ([self.LOW], (Unwatch("2"),)) == (met, of(connection, Advance)[1].commands)
        assert (Watched("1", self.LOW), Watched("2", other)) == of(connection, Advance)[0].commands

    def test_one_that_can_not_be_watched_is_an_error(self, connection, lockstep):
        connection.script[Advance] = [Granted(5, 2.5, "until", (RequestError("no topic 'smell'"),))]

        with pytest.raises(RequestError, match="no topic 'smell'"):
            lockstep.wait_for(self.LOW)

    def test_the_end_of_lockstep_is_an_error(self, connection, lockstep):
        connection.script[Advance] = [Granted(5, 2.5, "end", (Watching(True),))]

        with pytest.raises(RequestError, match="lockstep is over; subscribe to the topic"):
            lockstep.wait_for(self.LOW)
