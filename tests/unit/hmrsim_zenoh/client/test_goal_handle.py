"""The states of a goal: what the client makes of answers, of their loss, and of their order."""

from __future__ import annotations

import pytest

from hmrsim.actions import registry
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.nav2_msgs import NavigateToPose, Wait
from hmrsim.protocol.commands import CancelGoal, GetResult, SendGoal
from hmrsim.protocol.goal import CancelResponse, GoalStatus, ResultResponse
from hmrsim_zenoh.errors import (
    ClientClosed,
    GoalRejectedError,
    GoalTimeout,
    RequestError,
    RequestTimeout,
    ResultExpired,
    SimulatorGone,
)

GOAL = Wait.Goal(time=Duration(sec=2))
ID = "0123456789abcdef0123456789abcdef"
UNKNOWN = ResultResponse(GoalStatus.UNKNOWN, Wait.Result())


@pytest.fixture
def wait(client):
    return client.action_client("wall_e", registry()["wait"])


@pytest.fixture(params=["send_goal", "execute"])
def send(request, wait):
    """Return the function that sends the goal, in two requests or in one."""
    return lambda **options: getattr(wait, request.param)(GOAL, **options)


class TestTrip:
    """A goal from its sending to its end."""

    def test_acceptance_and_end_are_reported_in_order(self, connection, send):
        seen = []
        goal = send(on_change=lambda goal: seen.append((goal.status, goal.accepted, goal.done)))
        connection.goals[0].accept()
        connection.goals[0].succeed()

        assert seen == [(GoalStatus.ACCEPTED, True, False), (GoalStatus.SUCCEEDED, True, True)]
        assert goal.result() == Wait.Result()

    def test_the_result_is_asked_for_right_after_the_goal(self, connection, send):
        send()

        assert [1, 1] == [len(connection.goals[0].asked[kind]) for kind in (SendGoal, GetResult)]

    def test_a_result_may_come_before_the_acceptance(self, connection, wait):
        goal = wait.send_goal(GOAL)
        connection.goals[0].answer(GetResult, ResultResponse(GoalStatus.SUCCEEDED, Wait.Result()))
        connection.goals[0].accept()

        assert (goal.done, goal.accepted, goal.status) == (True, True, GoalStatus.SUCCEEDED)

    def test_a_goal_is_accepted_once(self, connection, wait):
        """A second answer, to a repeated request, changes nothing and runs no callback."""
        changes = []
        wait.send_goal(GOAL, on_change=changes.append)
        connection.goals[0].lose(SendGoal)
        connection.run_later()
        connection.goals[0].accept()
        connection.goals[0].accept()

        assert 1 == len(changes)

    def test_an_unwanted_result_is_read_only_if_the_goal_failed(self, connection, send):
        goals = [send(read_result=False) for _ in range(2)]
        connection.goals[0].succeed()
        connection.goals[1].abort(740, "tired")

        assert goals[0].result_message is None
        assert goals[1].result_message.error_msg == "tired"

    def test_the_callers_goal_id_is_used_without_hyphens(self, connection, send):
        goal = send(goal_id="01234567-89AB-cdef-0123-456789abcdef")

        assert ID == goal.goal_id == connection.goals[0].goal_id

    def test_invalid_arguments_are_reported_without_a_request(self, connection, client, wait):
        with pytest.raises(ValueError, match="'short' is not a UUID"):
            wait.send_goal(GOAL, goal_id="short")
        with pytest.raises(TypeError, match="wait takes nav2_msgs/action/Wait_Goal"):
            wait.send_goal(NavigateToPose.Goal())
        with pytest.raises(ValueError, match=r"'\*' is not a valid robot name"):
            client.action_client("*", registry()["wait"])
        assert [] == connection.goals

    def test_a_callback_that_raises_is_logged_and_the_goal_continues(self, connection, send, caplog):
        goal = send(on_change=lambda _goal: 1 / 0)
        connection.goals[0].succeed()

        assert goal.done
        assert "ZeroDivisionError" in caplog.text

    def test_callbacks_may_send_goals(self, connection, wait):
        """Each goal of a chain is sent when the previous one has ended."""
        connection.robot = lambda goal: goal.succeed()

        def go_on(goal):
            if goal.done and len(connection.goals) < 20:
                wait.send_goal(GOAL, on_change=go_on)

        wait.send_goal(GOAL, on_change=go_on)

        assert [True] * 20 == [goal.done for goal in connection.goals]


class TestRefusals:
    def test_a_rejected_goal_has_a_reason_and_a_message(self, connection, send):
        goal = send()
        connection.goals[0].reject("busy", "because of orders")

        with pytest.raises(GoalRejectedError, match="busy: because of orders") as caught:
            goal.result()
        assert (caught.value.reason, caught.value.error_code, goal.accepted) == ("busy", 1, False)
        with pytest.raises(GoalRejectedError):
            goal.wait_accepted()

    def test_a_duplicate_at_the_first_try_is_a_rejection(self, connection, send):
        """The id belongs to another client's goal, whose result is not ours."""
        goal = send(goal_id=ID)
        connection.goals[0].is_known(GoalStatus.EXECUTING)

        with pytest.raises(GoalRejectedError, match="duplicate_goal_id"):
            goal.result()

    def test_an_error_fails_the_goal(self, connection, send):
        goal = send()
        connection.goals[0].fail(RequestError("no", [{"field": "goal.time.sec"}]))

        with pytest.raises(RequestError, match="no"):
            goal.result()
        assert (goal.done, goal.accepted, connection.goals[0].sent) == (True, None, 1)


class TestLosses:
    def test_a_goal_whose_answer_was_lost_is_sent_again(self, connection, wait):
        """The second request finds our own goal: it counts as accepted, with its present status."""
        goal = wait.send_goal(GOAL)
        connection.goals[0].lose(SendGoal)
        connection.run_later()
        connection.goals[0].is_known(GoalStatus.EXECUTING)

        assert (goal.accepted, goal.status, goal.adopted) == (True, GoalStatus.EXECUTING, False)
        assert (len(connection.goals), connection.goals[0].sent) == (1, 2)

    def test_a_duplicate_that_has_ended_is_accepted_until_its_result_comes(self, connection, wait):
        """A terminal status is reported only with its result."""
        goal = wait.send_goal(GOAL)
        connection.goals[0].lose(SendGoal)
        connection.run_later()
        connection.goals[0].is_known(GoalStatus.ABORTED)
        before = goal.status, goal.done
        connection.goals[0].abort(740, "tired")

        assert (before, goal.status) == ((GoalStatus.ACCEPTED, False), GoalStatus.ABORTED)

    def test_the_pause_between_two_tries_grows(self, connection, wait):
        wait.send_goal(GOAL)
        pauses = []
        for _ in range(7):
            connection.goals[0].lose(SendGoal)
            pauses.append(connection.later[0][0])
            connection.run_later()

        assert (0.05, 0.4) == (pauses[0], pauses[-1])
        assert sorted(pauses) == pauses

    @pytest.mark.parametrize("early", ["lost", "unknown"])
    def test_a_result_asked_for_too_early_is_asked_for_again(self, connection, wait, early):
        """Status 0 from before the acceptance does not mean that the goal is forgotten."""
        goal = wait.send_goal(GOAL)
        sent = connection.goals[0]
        sent.lose(SendGoal)
        first = sent.asked[GetResult].pop(0)
        first(UNKNOWN if early == "unknown" else None)
        connection.run_later()
        sent.accept()
        assert 1 == len(sent.asked[GetResult])
        sent.succeed()

        assert goal.done

    def test_status_0_from_before_the_acceptance_is_ignored_when_it_comes_late(self, connection, wait):
        goal = wait.send_goal(GOAL)
        connection.goals[0].accept()
        connection.goals[0].asked[GetResult].pop(0)(UNKNOWN)
        asked = len(connection.goals[0].asked[GetResult])
        connection.goals[0].succeed()

        assert (1, True) == (asked, goal.done)

    def test_a_result_whose_answer_was_lost_is_asked_for_again(self, connection, send):
        goal = send()
        connection.goals[0].accept()
        for _ in range(3):
            connection.goals[0].lose(GetResult)
            connection.run_later()
        connection.goals[0].succeed()

        assert goal.status is GoalStatus.SUCCEEDED

    def test_a_goal_that_is_never_answered_times_out(self, connection, wait):
        """The goal is canceled as well, since the simulator may have accepted it."""
        goal = wait.send_goal(GOAL)
        connection.goals[0].lose(SendGoal)
        connection.wall = 2.0
        connection.run_later()

        with pytest.raises(GoalTimeout, match=r"no answer to goal .* in 2 s; the goal is given up"):
            goal.result()
        assert connection.goals[0].canceled

    def test_an_unanswered_execution_is_replaced_by_the_other_keys(self, connection, wait):
        """Late answers to the first request are ignored."""
        goal = wait.execute(GOAL)
        connection.run_later()
        connection.run_later()
        late, again = connection.goals[0].asked[SendGoal]
        connection.goals[0].succeed()
        for then in (late, again):
            then(None)

        assert (goal.status, connection.goals[0].sent) == (GoalStatus.SUCCEEDED, 2)

    def test_the_result_of_a_simulator_that_forgot_the_goal_is_an_error(self, connection, wait):
        goal = wait.send_goal(GOAL)
        connection.goals[0].accept()
        connection.goals[0].lose(GetResult)
        connection.run_later()
        connection.goals[0].answer(GetResult, UNKNOWN)

        with pytest.raises(SimulatorGone, match=r"does not know goal .* any more"):
            goal.result()


class TestAdopt:
    def test_a_running_goal_is_followed(self, connection, wait):
        goal = wait.send_goal(GOAL, goal_id=ID, adopt=True)
        connection.goals[0].is_known(GoalStatus.EXECUTING)
        before = goal.adopted, goal.found, goal.status
        connection.goals[0].succeed()

        assert before == (True, GoalStatus.EXECUTING, GoalStatus.EXECUTING)
        assert goal.status is GoalStatus.SUCCEEDED

    def test_a_result_that_is_not_kept_is_an_error_with_the_status(self, connection, wait):
        goal = wait.send_goal(GOAL, goal_id=ID, adopt=True)
        connection.goals[0].expire(GoalStatus.SUCCEEDED)

        with pytest.raises(ResultExpired, match=f"goal {ID} is SUCCEEDED, but its result is not kept any longer"):
            goal.result()
        assert goal.status is GoalStatus.SUCCEEDED


class TestCancel:
    def test_a_canceled_goal_is_canceling_and_then_canceled(self, connection, send):
        seen = []
        goal = send(on_change=lambda goal: seen.append(goal.status))
        connection.goals[0].accept()
        goal.cancel()
        connection.goals[0].cancel()
        connection.goals[0].end_canceled()

        assert [GoalStatus.ACCEPTED, GoalStatus.CANCELING, GoalStatus.CANCELED] == seen

    def test_a_cancel_waits_for_the_acceptance_and_is_sent_once(self, connection, send):
        goal = send()
        goal.cancel()
        goal.cancel()
        before = connection.goals[0].canceled
        connection.goals[0].accept()

        assert (False, 1) == (before, len(connection.goals[0].asked[CancelGoal]))

    def test_a_cancel_of_a_rejected_goal_is_never_sent(self, connection, send):
        goal = send()
        goal.cancel()
        connection.goals[0].reject()

        assert not connection.goals[0].canceled

    def test_a_cancel_whose_answer_was_lost_is_sent_again(self, connection, send):
        goal = send()
        connection.goals[0].accept()
        goal.cancel()
        connection.goals[0].lose(CancelGoal)
        connection.run_later()
        connection.run_later()

        assert 1 == len(connection.goals[0].asked[CancelGoal])

    @pytest.mark.parametrize("code", [2, 3])
    def test_after_a_late_cancel_the_result_decides(self, connection, send, code):
        goal = send()
        connection.goals[0].accept()
        goal.cancel()
        connection.goals[0].answer(CancelGoal, CancelResponse(code))
        connection.goals[0].succeed()

        assert goal.status is GoalStatus.SUCCEEDED

    @pytest.mark.parametrize("answer", [CancelResponse(1), RequestError("no")])
    def test_a_rejected_cancel_can_be_requested_again(self, connection, send, answer, caplog):
        goal = send()
        connection.goals[0].accept()
        goal.cancel()
        connection.goals[0].asked[CancelGoal].pop(0)(answer)
        goal.cancel()

        assert 1 == len(connection.goals[0].asked[CancelGoal])
        assert ("can't be canceled: no" in caplog.text) is isinstance(answer, RequestError)

    def test_all_goals_of_an_action_can_be_canceled(self, connection, client, wait):
        for each in (wait, wait, client.action_client("eve", registry()["wait"])):
            each.send_goal(GOAL)
        wait.cancel_all()

        assert [True, True, False] == [goal.canceled for goal in connection.goals]

    @pytest.mark.parametrize("error", [RequestError("no such action"), None])
    def test_a_refused_or_unanswered_cancel_of_all_goals_is_an_error(self, connection, wait, error, monkeypatch):
        monkeypatch.setattr(connection, "send", lambda _target, _command, then, **_: then(error))

        with pytest.raises(
            type(error) if error else RequestTimeout, match=r"no such action|/wall_e/wait: no answer to"
        ):
            wait.cancel_all()


class TestFeedback:
    def test_a_goal_gets_only_its_own_feedback_until_it_ends(self, connection, send):
        seen = []
        goal = send(on_feedback=seen.append)
        send(on_feedback=lambda _: None)
        for sent in connection.goals:
            sent.accept()
            sent.feed(time_left=Duration(sec=2))
        status = goal.status
        connection.goals[0].succeed()
        connection.goals[0].feed(time_left=Duration(sec=1))

        assert [Wait.Feedback(time_left=Duration(sec=2))] == seen == [goal.feedback]
        assert status is GoalStatus.EXECUTING

    def test_a_feedback_callback_can_cancel_the_goal(self, connection, send):
        goals = []
        goals.append(send(on_feedback=lambda _: goals[0].cancel()))
        connection.goals[0].accept()
        connection.goals[0].feed()

        assert connection.goals[0].canceled

    def test_the_client_subscribes_only_with_a_callback(self, connection, send):
        send()
        assert not connection.listeners

        send(on_feedback=lambda _: None)
        assert connection.listeners


class TestAbsence:
    """A simulator that leaves, and a client that is closed."""

    def test_goals_fail_when_the_simulator_has_been_gone_for_longer_than_the_grace(self, connection, wait):
        goal = wait.send_goal(GOAL)
        connection.goals[0].accept()
        connection.vanish()
        for connection.wall in (4.9, 5.0):
            before = goal.done
            connection.run_later()
        connection.run_later()

        with pytest.raises(SimulatorGone, match="its token 'hmrsim/_world/alive' has disappeared"):
            goal.result()
        assert (before, goal.accepted) == (False, True)

    def test_a_lost_answer_of_a_simulator_that_has_gone_fails_the_goal(self, connection, wait):
        goal = wait.send_goal(GOAL)
        connection.vanish()
        connection.wall = 5.0
        connection.goals[0].lose(SendGoal)

        with pytest.raises(SimulatorGone):
            goal.result()

    def test_goals_that_callbacks_send_after_that_fail_as_well(self, connection, client, wait):
        ends = []

        def try_again(goal):
            if goal.done:
                ends.append(type(goal.error))
                if len(ends) < 3:
                    wait.send_goal(GOAL, on_change=try_again)

        assert client.alive
        connection.robot = lambda goal: goal.lose(SendGoal)
        connection.vanish()
        connection.wall = 5.0
        wait.send_goal(GOAL, on_change=try_again)

        assert [SimulatorGone] * 3 == ends

    def test_closing_the_client_fails_its_open_goals(self, client, wait):
        goal = wait.send_goal(GOAL)
        client.close()

        with pytest.raises(ClientClosed, match="the client was closed while the goal was under way"):
            goal.result()
        with pytest.raises(ClientClosed, match="closed"):
            wait.send_goal(GOAL)
        with pytest.raises(ClientClosed, match="closed"):
            client.get("hmrsim/_world/info")
