"""Samples in simulated time, which subscribers get without changing the run."""

from __future__ import annotations

import math

import pytest

from hmrsim.interfaces.nav2_msgs import NavigateToPose
from hmrsim.protocol.commands import InterestChanged, SendGoal
from hmrsim.protocol.outputs import Sampled, StatusChanged
from hmrsim.protocol.topics import Topic
from tests.simulation import simulate, wait

GO = wait(1)


def sampled(log, topic):
    return [time for time, event in log.events if isinstance(event, Sampled) and event.topic is topic]


def test_the_clock_is_published_ten_times_per_second(make_run):
    run = make_run(topics=frozenset({Topic.CLOCK}))
    log = run(until=0.55)

    assert [0.1, 0.2, 0.3, 0.4, 0.5] == pytest.approx(sampled(log, Topic.CLOCK))
    assert 500_000_000 == log.events[-1][1].message.clock.to_nanoseconds()


def test_nothing_is_sampled_without_a_subscriber(make_run):
    run = make_run(topics=frozenset())
    log = run(until=5.0)

    assert [] == log.events
    assert math.inf == run.simulator.next_due


def test_sampling_begins_with_the_first_subscriber(make_run):
    """The first sample is at the next multiple of the period."""
    run = make_run(topics=frozenset())
    run(until=1.23)
    run.log.topics = frozenset({Topic.CLOCK})
    log = run((1.23, InterestChanged()), until=1.45)

    assert [1.3, 1.4] == pytest.approx(sampled(log, Topic.CLOCK))


def test_sampling_ends_with_the_last_subscriber(run):
    run(until=0.5)
    run.log.topics = frozenset()
    run((0.5, InterestChanged()))

    assert math.inf == run.simulator.next_due


def test_odometry_has_pose_and_speed(make_run):
    goal = NavigateToPose.Goal.model_validate_json('{"pose": {"pose": {"position": {"x": 9, "y": 2}}}}')
    run = make_run(topics=frozenset({Topic.ODOM}))
    log = run((0.0, SendGoal("wall_e", "navigate_to_pose", goal, "a" * 32)), until=0.5)
    odom = [event.message for _, event in log.events if isinstance(event, Sampled) and event.robot == "wall_e"][-1]

    assert ("map", "wall_e/base_link") == (odom.header.frame_id, odom.child_frame_id)
    assert (1.5, 1.0) == pytest.approx((odom.pose.pose.position.x, odom.twist.twist.linear.x))


def test_subscribers_do_not_change_what_happens():
    quiet, loud = simulate(topics=frozenset()), simulate()

    assert quiet((0.0, GO)).changes("a" * 32) == loud((0.0, GO)).changes("a" * 32)


def test_a_late_subscriber_gets_the_last_status(make_run):
    run = make_run(topics=frozenset())
    run((0.0, wait(9)), until=1.0)
    run.log.topics = frozenset({Topic.STATUS})

    run.simulator.stop()

    assert [6] == [event.goals[0].status for _, event in run.log.events if isinstance(event, StatusChanged)]
