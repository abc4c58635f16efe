"""Stalled, expected and absent participants."""

from __future__ import annotations

import math

import pytest

from hmrsim.protocol.outputs import Granted
from hmrsim.timing.participants import Participants
from tests import simulation
from tests.steps import RESULT, Steps


def wait(robot, seconds):
    return simulation.wait(seconds, None, robot)


def robots(granted):
    """Return the robots whose events a grant reports, in order."""
    return [event.robot for _, _, event in granted.events]


@pytest.fixture
def steps():
    """Return a simulation that two participants have joined."""
    two = Steps()
    two.join("ada", "ben")
    return two


class TestStalled:
    """Participants that a disturbance has stalled."""

    def test_the_others_go_on(self, steps):
        steps.ask("ada", 0, 2.0)
        asked = steps.ask("ben", 0, 8.0)
        steps.lockstep.stall("ada", 10.0)
        steps.move()

        assert Granted(1, 8.0, "until") == steps.answers(asked)

    def test_it_is_told_of_all_at_once(self, steps):
        """It gets the events of the grants that it missed, in order, and the answers to its commands."""
        held = steps.ask("ada", 0, 2.0, wait("eve", 3), wait("wall_e", 5))
        steps.ask("ben", 0, 4.0)
        steps.lockstep.stall("ada", 10.0)
        steps.move()
        steps.advance("ben", 1, 20.0)
        steps.advance("ben", 2, 20.0)
        granted = steps.answers(held)

        assert (10.0, "until", ["eve", "wall_e"]) == (granted.now, granted.reason, robots(granted))
        assert [True, True] == [answer.accepted for answer in granted.accepted]

    def test_it_gets_the_feedback_of_the_instant_at_which_it_is_answered(self, steps):
        """Once, like a participant that was not stalled, and however many grants it missed."""
        held = steps.ask("ada", 0, 1.0, simulation.go(9, 2, None), report={"feedback"})
        steps.ask("ben", 0, 2.0)
        steps.lockstep.stall("ada", 4.0)
        steps.move()
        steps.advance("ben", 1, 3.0)
        steps.advance("ben", 2, 20.0)
        ((_, _, feedback),) = steps.answers(held).events

        assert 4.0 == pytest.approx(feedback.feedback["distance_remaining"])

    def test_its_events_wake_nobody(self, steps):
        """Only the stalled participant waits for the result and for the rejection of its goal."""
        steps.ask("ada", 0, math.inf, wait("eve", 3), wait("nobody", 3))
        asked = steps.ask("ben", 0, 8.0, wake=frozenset())
        steps.lockstep.stall("ada", 10.0)
        steps.move()

        assert Granted(1, 8.0, "until") == steps.answers(asked)

    def test_it_does_not_hear_what_was_to_wake_it(self):
        """A stall at the instant of its result comes before the grant that reports it."""
        one = Steps()
        one.join("ada")
        asked = one.ask("ada", 0, 10.0, wait("eve", 3))
        one.lockstep.begin()
        while one.simulator.now < 3.0:
            one.simulator.process_events(3.0, 1)
        one.lockstep.stall("ada", 7.0)
        while one.lockstep.proceed(16, 0.0):
            pass
        granted = one.answers(asked)

        assert (7.0, ["eve"]) == (granted.now, robots(granted))

    def test_a_further_stall_keeps_what_it_asks_unheard(self, steps):
        steps.lockstep.stall("ada", 5.0)
        asked = steps.ask("ada", 0, 20.0, wait("eve", 3))
        steps.lockstep.stall("ada", 10.0)
        ben = steps.advance("ben", 0, 15.0)
        steps.advance("ben", 1, 15.0)

        assert (10.0, ()) == (ben.now, ben.events)
        assert (13.0, ["eve"]) == (steps.answers(asked).now, robots(steps.answers(asked)))

    def test_time_goes_on_while_all_are_stalled(self, steps):
        held, asked = steps.ask("ada", 0, 2.0), steps.ask("ben", 0, 2.0)
        steps.lockstep.stall("ada", 10.0)
        steps.lockstep.stall("ben", 20.0)
        steps.move()

        assert (10.0, None) == (steps.answers(held).now, steps.answers(asked))

    def test_the_longest_stall_counts(self, steps):
        held = steps.ask("ada", 0, 2.0)
        steps.leave("ben")
        steps.lockstep.stall("ada", 10.0)
        steps.lockstep.stall("ada", 5.0)
        steps.move()

        assert 10.0 == steps.answers(held).now

    def test_one_that_thinks_is_not_waited_for(self, steps):
        """It may still ask for its epoch later, and gets the events that it missed."""
        steps.ask("ada", 0, 1.0)
        steps.advance("ben", 0, 1.0)
        steps.lockstep.stall("ada", 10.0)
        steps.advance("ben", 1, 5.0, wait("eve", 3))
        steps.advance("ben", 2, 9.0)
        steps.advance("ben", 3, 30.0)
        steps.ask("ben", 4, 30.0)
        waited_for, granted = steps.lockstep.waiting_for, steps.advance("ada", 1, 12.0)

        assert ("ada",) == waited_for
        assert (10.0, ["eve"]) == (granted.now, robots(granted))

    def test_it_is_not_overdue(self, steps):
        steps.lockstep.stall("ada", 10.0)

        assert ["ben"] == steps.lockstep.overdue(1.0)

    def test_a_stranger_is_not_stalled(self, steps):
        steps.lockstep.stall("carl", 10.0)
        steps.ask("ada", 0, 12.0)

        assert Granted(1, 12.0, "until") == steps.advance("ben", 0, 12.0)

    def test_the_end_of_the_run_ends_it(self):
        one = Steps(until=5.0)
        one.join("ada")
        held = one.ask("ada", 0, 2.0)
        one.lockstep.stall("ada", 10.0)
        one.move()

        assert (5.0, "end") == (one.answers(held).now, one.answers(held).reason)


class TestExpected:
    """Participants that are expected to join later."""

    def test_time_goes_on_and_waits(self):
        steps, calls = Steps(), []
        steps.join("ada")
        steps.lockstep.expect("ben", 5.0, lambda: calls.append(steps.simulator.now))
        steps.lockstep.drop("ada", "it was killed")
        steps.move()

        assert ([5.0], ("ben",), 5.0) == (calls, steps.lockstep.waiting_for, steps.simulator.now)

    def test_time_goes_on_when_it_has_joined(self, steps):
        steps.leave("ben")
        steps.lockstep.expect("ben", 5.0)
        asked = steps.ask("ada", 0, 20.0)
        steps.move()
        early = steps.answers(asked)
        steps.join("ben")
        steps.ask("ben", 1, 7.0)

        assert (5.0, 7.0) == (early.now, steps.advance("ada", 1, 20.0).now)

    def test_it_may_not_come(self, steps):
        steps.lockstep.expect("carl")
        asked = steps.ask("ada", 0, 20.0)
        steps.ask("ben", 0, 20.0)
        steps.move()
        before = steps.answers(asked)
        steps.lockstep.expect_no_more("carl")
        steps.move()

        assert (None, 20.0) == (before, steps.answers(asked).now)

    def test_a_grant_under_way_ends_for_it(self, steps):
        asked = steps.ask("ada", 0, 20.0, wake=RESULT)
        steps.ask("ben", 0, 20.0)
        steps.lockstep.begin()
        steps.lockstep.expect("carl")
        while steps.lockstep.proceed(16, 0.0):
            pass

        assert 0.0 == steps.answers(asked).now

    def test_one_that_is_kept_is_waited_for_when_it_has_gone(self, steps):
        """Time waits until it has joined again, or no participant is expected."""
        steps.lockstep.keep("ada")
        steps.leave("ada")
        asked = steps.ask("ben", 0, 20.0)
        steps.move()
        before = steps.answers(asked), steps.lockstep.expects
        steps.lockstep.expect_nobody()
        steps.move()

        assert ((None, True), 20.0, False) == (before, steps.answers(asked).now, steps.lockstep.expects)

    def test_time_goes_on_for_nobody_as_far_as_anything_is_scheduled(self):
        steps = Steps()
        steps.join("ada")
        steps.advance("ada", 0, 1.0, wait("eve", 3))
        steps.lockstep.expect("", math.inf)
        steps.lockstep.drop("ada", "it was killed")
        steps.move()

        assert (3.0, False) == (steps.simulator.now, steps.lockstep.ready)


def test_who_never_comes_is_waited_for_no_longer():
    """The idle grant comes when no participant is left to act, and later ones are still expected."""
    participants = Participants(0)
    participants.expect("ada", math.inf, lambda: None)
    participants.expect("ben", 3.0, lambda: None)
    participants.expect_only_those_that_come()
    later = participants.later
    participants.expect_no_more("ben")

    assert (True, False) == (later, participants.later)
