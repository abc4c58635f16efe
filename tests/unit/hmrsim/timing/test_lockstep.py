"""Time that moves only as far as its controllers allow."""

from __future__ import annotations

import math

import pytest

from hmrsim.protocol.commands import CancelGoal, GetResult
from hmrsim.protocol.goal import Refused, made_goal_id
from hmrsim.protocol.outputs import FeedbackSent, GoalChanged, Granted
from hmrsim.protocol.time import HasLeft, Join, Joined
from hmrsim.protocol.topics import Topic
from tests import simulation
from tests.simulation import in_lockstep
from tests.steps import Steps


def wait(robot, seconds, goal_id=None):
    return simulation.wait(seconds, goal_id, robot)


def go(robot, x, y):
    return simulation.go(x, y, None, robot)


def kinds(granted):
    """Return kind, robot and time of each event of a grant."""
    return [(kind, event.robot, stamp / 1e9) for kind, stamp, event in granted.events]


@pytest.fixture
def steps():
    """Return a simulation that one participant has joined."""
    one = Steps(topics=frozenset({Topic.EVENTS}))
    one.join("alone")
    return one


class TestOne:
    """Lockstep with a single participant only."""

    def test_joining_tells_where_to_begin(self):
        assert Joined("nurse", 0, 0.0, 0) == Steps().join("nurse")

    def test_time_stands_until_it_asks(self, steps):
        steps.simulator.submit(wait("eve", 1))
        steps.move()

        assert 0.0 == steps.simulator.now

    def test_it_is_woken_by_a_result(self, steps):
        granted = steps.advance("alone", 0, 10.0, wait("eve", 3), wait("wall_e", 5))

        assert (1, 3.0, "event") == granted[:3]
        assert [("result", "eve", 3.0)] == kinds(granted)

    def test_all_that_happens_at_the_instant_is_told_at_once(self, steps):
        granted = steps.advance("alone", 0, 10.0, wait("eve", 3), wait("wall_e", 3))

        assert [("result", "eve", 3.0), ("result", "wall_e", 3.0)] == kinds(granted)

    def test_it_gets_the_time_it_asks_for(self, steps):
        assert Granted(1, 2.5, "until") == steps.advance("alone", 0, 2.5)

    def test_a_time_that_has_been_is_granted_at_once(self, steps):
        steps.advance("alone", 0, 5.0)

        assert (2, 5.0, "until") == steps.advance("alone", 1, 2.0)[:3]

    def test_it_is_never_told_an_earlier_time_than_it_asked_for(self, steps):
        """Times are whole nanoseconds, unlike a third of a second."""
        assert 1 / 3 == steps.advance("alone", 0, 1 / 3).now

    def test_nothing_scheduled_is_idle_at_once(self, steps):
        assert Granted(1, 0.0, "idle") == steps.advance("alone", 0)

    def test_the_answers_to_its_commands_come_in_their_order(self, steps):
        granted = steps.advance("alone", 0, 1.0, wait("eve", 3), wait("nobody", 3), CancelGoal("eve", "wait"))
        accepted, rejected, canceled = granted.accepted

        assert (True, False, 0) == (accepted.accepted, rejected.accepted, canceled.return_code)
        assert "unknown_robot" == rejected.reason

    def test_a_goal_that_is_rejected_wakes_it(self, steps):
        """No event will follow a rejected goal."""
        granted = steps.advance("alone", 0, 10.0, wait("eve", 3), wait("nobody", 3))

        assert (0.0, "event") == (granted.now, granted.reason)

    def test_its_goals_are_numbered(self, steps):
        """The ids are made from the participant's name and the number of its goals, across grants."""
        first = steps.advance("alone", 0, 1.0, wait("eve", 3))
        second = steps.advance("alone", 1, 2.0, wait("wall_e", 3))

        expected = [made_goal_id("alone", 1), made_goal_id("alone", 2)]
        assert expected == [first.accepted[0].goal_id, second.accepted[0].goal_id]

    def test_numbers_go_on_when_it_joins_again(self, steps):
        """No goal id is generated twice."""
        steps.advance("alone", 0, 1.0, wait("eve", 3))
        steps.leave("alone")

        assert 1 == steps.join("alone").goals

    def test_a_lost_answer_is_given_again(self, steps):
        """A request for the same epoch applies no command twice."""
        granted = steps.advance("alone", 0, 1.0, wait("eve", 3))

        assert granted == steps.advance("alone", 0, 1.0, wait("eve", 3))
        assert 1.0 == steps.simulator.now

    def test_after_a_reset_the_same_epoch_is_another_one(self, steps):
        """Epochs begin at 0 again, and earlier answers are not repeated."""
        steps.advance("alone", 0, 5.0)
        steps.run.ask("reset_simulation")
        steps.lockstep.restart()

        assert Granted(1, 2.0, "until") == steps.advance("alone", 0, 2.0)

    def test_asking_again_while_the_answer_is_held_gets_it_too(self, steps):
        steps.join("other")
        first, second = steps.ask("alone", 0, 1.0), steps.ask("alone", 0, 1.0)
        steps.advance("other", 0, 1.0)

        assert steps.answers(first) == steps.answers(second) == Granted(1, 1.0, "until")

    def test_another_epoch_is_refused(self, steps):
        expected = Refused("epoch", 7, "epoch 7 is not the current one, which is 0")

        assert expected == steps.advance("alone", 7, 1.0)

    def test_a_name_that_has_joined_is_refused(self, steps):
        assert "participant 'alone' has joined already; take another name" == steps.join("alone").message

    def test_joining_again_with_its_token_gets_the_same_answer(self):
        """The first answer may be lost; another client with the same name is refused."""
        run, lockstep = in_lockstep()
        for number, token in enumerate(("mine", "mine", "", "other")):
            lockstep.join(Join("nurse", number, token), 0.0)
        answers = [run.log.answers(number)[0] for number in range(4)]

        assert [Joined("nurse", 0, 0.0, 0)] * 2 == answers[:2]
        assert [Refused] * 2 == [type(answer) for answer in answers[2:]]

    def test_a_stranger_is_refused(self, steps):
        assert "no participant 'zoe'; join first" == steps.advance("zoe", 0).message
        assert "no participant 'zoe'; join first" == steps.leave("zoe").message

    def test_leaving_is_answered_and_told(self, steps):
        assert HasLeft("alone") == steps.leave("alone")
        assert [("participant_joined", "alone"), ("participant_left", "alone")] == steps.happened()
        assert not steps.lockstep.ready

    def test_status_wakes_a_participant_that_wants_it(self, steps):
        granted = steps.advance("alone", 0, 9.0, wait("eve", 3), wake={"status"})

        assert 0.0 == granted.now
        assert [1, 2] == [event.status for _, _, event in granted.events]

    def test_a_result_is_told_with_the_status(self, steps):
        steps.advance("alone", 0, 0.0, wait("eve", 3), wake=())
        granted = steps.advance("alone", 1, 9.0, wake={"status", "result"})

        assert ["status", "result"] == [kind for kind, _, _ in granted.events]

    def test_feedback_wakes_a_participant_that_wants_it(self, steps):
        """The first feedback is due 0.1 s after the goal began."""
        granted = steps.advance("alone", 0, 9.0, go("wall_e", 5, 2), wake={"feedback"})

        assert [("feedback", "wall_e", 0.1)] == kinds(granted)

    def test_feedback_is_reported_in_the_order_of_robots(self, steps):
        """An earlier request for the result makes no difference."""
        steps.simulator.submit(GetResult("wall_e", "navigate_to_pose", "a" * 32, "x"))
        goals = [go("wall_e", 9, 2), go("cart", 9, 2)]
        granted = steps.advance("alone", 0, 1.0, *goals, report={"feedback"})

        assert ["cart", "wall_e"] == [event.robot for _, _, event in granted.events]

    def test_feedback_is_reported_without_waking(self, steps):
        """A grant reports one sample of each goal, of the instant at which it ends."""
        granted = steps.advance("alone", 0, 2.0, go("wall_e", 5, 2), report={"feedback"})
        ((_, _, feedback),) = granted.events

        assert isinstance(feedback, FeedbackSent)
        assert 2.0 == pytest.approx(feedback.feedback["distance_remaining"])

    def test_what_happens_while_it_thinks_is_told_next(self, steps):
        steps.advance("alone", 0, 1.0, wait("eve", 3))
        steps.simulator.submit(CancelGoal("eve", "wait"))
        granted = steps.advance("alone", 1, 9.0)

        assert (1.0, "event") == (granted.now, granted.reason)
        assert [("result", "eve", 1.0)] == kinds(granted)

    def test_time_does_not_go_on_for_what_was_canceled(self, steps):
        """Nothing is left in the schedule, neither the end of a wait nor that of a lane."""
        steps.advance("alone", 0, 1.0, wait("eve", 3), go("wall_e", 9, 2))
        commands = CancelGoal("eve", "wait"), CancelGoal("wall_e", "navigate_to_pose")
        steps.advance("alone", 1, 1.0, *commands)

        assert (1.0, "idle") == (steps.advance("alone", 2).now, steps.advance("alone", 3).reason)

    def test_asking_for_the_next_epoch_while_waiting_is_refused(self, steps):
        steps.simulator.gate.limit = 0.0
        steps.ask("alone", 0, 5.0)

        assert "epoch 0 is pending" in steps.advance("alone", 1, 5.0).message


class TestSeveral:
    """Lockstep with several participants at once."""

    def test_no_participant_is_granted_before_all_ask(self):
        steps = Steps()
        steps.join("a", "b")
        held = steps.ask("a", 0, 5.0)
        steps.move()

        assert steps.answers(held) is None
        assert ("b",) == steps.lockstep.waiting_for

    def test_the_least_time_is_granted(self):
        steps = Steps()
        steps.join("a", "b")
        held = steps.ask("a", 0, 5.0)

        assert steps.advance("b", 0, 2.0) == steps.answers(held) == Granted(1, 2.0, "until")

    def test_commands_are_applied_in_the_order_of_names(self):
        """The order of requests does not decide which of two robots gets the same base."""
        for order in (("a", "b"), ("b", "a")):
            steps = Steps()
            steps.join(*order)
            for name in order:
                steps.ask(name, 0, 1.0, wait("eve", 3), wake=())
            steps.move()
            ends = [e.goal_id for _, e in steps.run.log.events if isinstance(e, GoalChanged) and e.status.terminal]

            assert [made_goal_id("a", 1)] == ends

    def test_they_are_answered_in_the_order_of_names(self):
        steps = Steps()
        steps.join("b", "a")
        b, a = steps.ask("b", 0, 1.0), steps.ask("a", 0, 1.0)
        steps.move()
        answered = [event.reply_to for _, event in steps.run.log.events if getattr(event, "reply_to", None) in (a, b)]

        assert [a, b] == answered

    def test_each_is_told_what_it_wants(self):
        steps = Steps()
        steps.join("a", "b")
        held = steps.ask("a", 0, 9.0, wait("eve", 3), wake=())
        granted = steps.advance("b", 0, 9.0)

        assert ([], [("result", "eve", 3.0)]) == (kinds(steps.answers(held)), kinds(granted))
        assert 3.0 == steps.answers(held).now

    def test_time_stands_until_enough_have_joined(self):
        steps = Steps(awaited=2)
        steps.join("a")
        held = steps.ask("a", 0, 1.0)
        steps.move()
        missing = steps.lockstep.waiting_for
        steps.join("b")
        steps.advance("b", 0, 1.0)

        assert ("1 more to join",) == missing
        assert Granted(1, 1.0, "until") == steps.answers(held)

    def test_time_stands_until_all_names_have_joined(self):
        steps = Steps(awaited=("a", "b"))
        steps.join("a", "zoe")
        for name in ("a", "zoe"):
            steps.ask(name, 0, 1.0)
        steps.move()

        assert (0.0, ("b",)) == (steps.simulator.now, steps.lockstep.waiting_for)

    @pytest.mark.parametrize("order", [("a", "b"), ("b", "a")])
    def test_joins_are_told_in_the_order_of_names(self, order):
        steps = Steps(topics=frozenset({Topic.EVENTS}))
        steps.join(*order)
        for name in order:
            steps.ask(name, 0, 1.0)
        steps.move()

        assert [("participant_joined", "a"), ("participant_joined", "b")] == steps.happened()

    def test_a_late_participant_begins_with_the_next_grant(self):
        steps = Steps()
        steps.join("a")
        steps.advance("a", 0, 1.0)
        joined = steps.join("b")
        held = steps.ask("a", 1, 2.0)
        steps.move()

        assert Joined("b", 1, 1.0, 0) == joined
        assert steps.answers(held) is None
        assert Granted(2, 2.0, "until") == steps.advance("b", 1, 3.0)

    def test_a_participant_that_joins_within_a_grant_begins_with_the_one_after(self):
        """It may ask for the next grant at once, and is not part of the current one."""
        steps = Steps(most=1)
        steps.join("a")
        held = steps.ask("a", 0, 9.0, wait("eve", 3))
        steps.lockstep.begin()
        steps.lockstep.proceed(1, 0.0)
        joined = steps.join("b")
        early = steps.ask("b", 1, 20.0)
        while steps.lockstep.proceed(1, 0.0):
            pass

        assert (1, 3.0) == (joined.epoch, steps.answers(held).now)
        assert steps.answers(early) is None

    def test_the_others_go_on_when_one_leaves(self):
        steps = Steps()
        steps.join("a", "b")
        held = steps.ask("a", 0, 5.0)
        steps.leave("b")
        steps.move()

        assert Granted(1, 5.0, "until") == steps.answers(held)


class TestLoss:
    def test_one_whose_token_goes_is_dropped(self):
        """The other participants go on, and an event gives the reason."""
        steps = Steps(topics=frozenset({Topic.EVENTS}))
        steps.join("a", "b")
        steps.lockstep.token_seen("b", alive=True)
        held = steps.ask("a", 0, 5.0)
        steps.lockstep.token_seen("b", alive=False)
        steps.move()

        assert 5.0 == steps.answers(held).now
        assert ("participant_dropped", "b") == steps.happened()[-1]
        assert steps.lockstep.lost

    def test_one_that_never_had_a_token_is_not_missed_by_it(self):
        """A script need not declare a token."""
        steps = Steps()
        steps.join("a")
        steps.lockstep.token_seen("a", alive=False)

        assert ("a",) == steps.lockstep.participants

    def test_a_token_may_be_there_before_it_joins(self):
        """The token may have been declared before the participant joined."""
        steps = Steps()
        steps.lockstep.token_seen("a", alive=True)
        steps.join("a")
        steps.lockstep.token_seen("a", alive=False)

        assert () == steps.lockstep.participants

    def test_a_participant_that_thinks_for_too_long_is_overdue(self):
        """The time counts from when it joined or got its last answer, and not while it waits."""
        steps = Steps()
        steps.join("a", "b")
        steps.ask("a", 0, 5.0)

        assert [] == steps.lockstep.overdue(0.0)
        assert ["b"] == steps.lockstep.overdue(1.0)

    def test_a_dropped_participant_is_told_so(self):
        """The error says when and why it was dropped, and what to do."""
        steps = Steps()
        steps.join("a")
        steps.lockstep.drop("a", "it died")

        assert "participant 'a' was dropped at 0.000 s: it died; join again" == steps.advance("a", 0).message
        assert Joined("a", 0, 0.0, 0) == steps.join("a")

    def test_a_participant_dropped_while_it_waits_is_told_so(self):
        steps = Steps()
        steps.join("a", "b")
        held = steps.ask("a", 0, 5.0)
        steps.lockstep.drop("a", "its liveliness token is gone")

        assert "participant 'a' was dropped at 0.000 s" in steps.answers(held).message

    def test_the_commands_of_one_that_is_dropped_are_not_applied(self):
        """The participant dies after it has asked, and before the others ask."""
        steps = Steps()
        steps.join("a", "b")
        steps.ask("b", 0, 5.0, wait("eve", 3))
        steps.lockstep.drop("b", "it died")
        steps.advance("a", 0, 5.0)

        assert [] == [event for _, event in steps.run.log.events if isinstance(event, GoalChanged)]


class TestHeld:
    """Pauses, steps and the end of the run."""

    def test_while_paused_an_advance_is_held(self, steps):
        steps.simulator.gate.limit = 0.0
        held = steps.ask("alone", 0, 5.0)
        steps.move()
        before = steps.answers(held)
        steps.simulator.gate.limit = math.inf
        steps.move()

        assert (None, 5.0) == (before, steps.answers(held).now)

    def test_a_pause_within_a_grant_holds_it(self, steps):
        """Time stops at the limit until it is lifted."""
        held = steps.ask("alone", 0, 5.0, wait("eve", 9))
        steps.lockstep.begin()
        steps.simulator.gate.limit = 2.0
        while steps.lockstep.proceed(16, 0.0):
            pass
        before = steps.answers(held), steps.simulator.now
        steps.simulator.gate.limit = math.inf
        while steps.lockstep.proceed(16, 0.0):
            pass

        assert ((None, 2.0), 5.0) == (before, steps.answers(held).now)

    def test_the_end_of_the_run_releases_all_participants(self):
        """The goals end at that time, with the reason of the end."""
        steps = Steps(until=4.0)
        steps.join("a")

        assert Granted(1, 4.0, "end", over="it was to last 4 s") == steps.advance("a", 0, 9.0)
        assert () == steps.lockstep.participants

    def test_dismissing_answers_waiting_participants(self):
        steps = Steps(awaited=2)
        steps.join("a")
        held = steps.ask("a", 0, 9.0)
        steps.lockstep.dismiss("over")

        assert "end" == steps.answers(held).reason

    def test_a_new_beginning_is_epoch_0(self):
        """A waiting participant gets the ends of its goals."""
        steps = Steps()
        steps.join("a", "b")
        steps.ask("a", 0, 1.0, wait("eve", 9))
        steps.advance("b", 0, 1.0)
        held = steps.ask("a", 1, 5.0)
        steps.simulator.submit(CancelGoal("eve", "wait"))
        steps.lockstep.restart()

        assert (0, "event") == (steps.answers(held).epoch, steps.answers(held).reason)
        assert [("result", "eve", 1.0)] == kinds(steps.answers(held))
        assert steps.lockstep.participants == ("a", "b")
