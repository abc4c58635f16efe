"""Leaves that look at what a robot publishes."""

from __future__ import annotations

import operator

import pytest
from py_trees.blackboard import Blackboard
from py_trees.common import ClearingPolicy, Status

from bt_controller.behaviours import battery, detections, places, subscribers
from bt_controller.core.robots import NotServed
from hmrsim.interfaces.geometry_msgs import Point, Pose, PoseWithCovariance
from hmrsim.interfaces.nav_msgs import Odometry
from hmrsim.interfaces.sensor_msgs import BatteryState
from hmrsim.interfaces.vision_msgs import (
    Detection3D,
    Detection3DArray,
    ObjectHypothesis,
    ObjectHypothesisWithPose,
)
from hmrsim_zenoh.client.connection import Condition
from hmrsim_zenoh.client.places import pose_at


def at(x):
    """Return the odometry of a robot at (x, 0)."""
    return Odometry(pose=PoseWithCovariance(pose=Pose(position=Point(x=x))))


def ticked(leaf):
    """Return the status of a leaf after one more tick."""
    leaf.tick_once()
    return leaf.status


@pytest.mark.parametrize(
    "make",
    [
        lambda: subscribers.CheckData("C", "odor", "pose", 1),
        lambda: subscribers.WaitForData("C", "odor"),
        lambda: subscribers.ToBlackboard("C", "odor", "key"),
        lambda: subscribers.EventToBlackboard("C", "odor", "key"),
    ],
)
def test_a_topic_that_there_is_not_is_refused_when_the_tree_is_built(make):
    with pytest.raises(ValueError, match="'C': no topic 'odor'; there are battery_state, detections, odom"):
        make()


@pytest.mark.parametrize(
    "make",
    [
        lambda: subscribers.CheckData("C", "odom", "pose.pose.x", 1),
        lambda: subscribers.ToBlackboard("C", "odom", {"x": "pose.pose.x"}),
    ],
)
def test_a_field_that_there_is_not_is_refused_when_the_tree_is_built(make):
    with pytest.raises(ValueError, match=r"'C': nav_msgs/msg/Odometry has no field 'pose.pose.x'"):
        make()


class TestCheckData:
    """A field of a message, compared with a value."""

    def test_it_waits_until_the_comparison_holds(self, topics, equip):
        leaf = equip(subscribers.CheckData("Past", "odom", "pose.pose.position.x", 2.0, operator.gt))
        statuses = []
        for x in (1.0, 3.0):
            topics.messages["odom"] = at(x)
            statuses.append(ticked(leaf))

        assert [Status.RUNNING, Status.SUCCESS] == statuses
        assert "'pose.pose.position.x' comparison succeeded [v: 3.0][e: 2.0]" == leaf.feedback_message

    def test_it_may_fail_instead_of_waiting(self, topics, equip):
        leaf = equip(subscribers.CheckData("At", "odom", "pose.pose.position.x", 2.0, fail_if_bad_comparison=True))
        topics.messages["odom"] = at(1.0)

        assert Status.FAILURE == ticked(leaf)

    @pytest.mark.parametrize(("fails", "expected"), [(True, Status.FAILURE), (False, Status.RUNNING)])
    def test_a_message_that_is_too_old_is_none(self, topics, equip, fails, expected):
        policy = ClearingPolicy.ON_INITIALISE
        leaf = equip(
            subscribers.CheckData(
                "At", "odom", "pose.pose.position.x", 2.0, fail_if_no_data=fails, clearing_policy=policy
            )
        )
        topics.messages["odom"] = at(2.0)

        assert expected == ticked(leaf)


def test_wait_for_data_waits_for_the_next_message(topics, equip):
    leaf = equip(subscribers.WaitForData("Wait", "odom"))
    topics.messages["odom"] = at(1.0)
    before = ticked(leaf)
    topics.messages["odom"] = at(1.0)

    assert (Status.RUNNING, Status.SUCCESS) == (before, ticked(leaf))


def test_wait_for_data_may_wait_for_a_message_since_its_last_success(topics, equip):
    leaf = equip(subscribers.WaitForData("Wait", "odom", clearing_policy=ClearingPolicy.ON_SUCCESS))
    topics.messages["odom"] = at(1.0)

    assert [Status.SUCCESS, Status.RUNNING] == [ticked(leaf), ticked(leaf)]


def test_a_message_goes_to_the_blackboard_whole_or_in_parts(topics, equip):
    leaf = equip(subscribers.ToBlackboard("B", "odom", {"odometry": None, "x": "pose.pose.position.x"}))
    topics.messages["odom"] = at(7.0)

    assert Status.SUCCESS == ticked(leaf)
    assert (at(7.0), 7.0) == (Blackboard.get("odometry"), Blackboard.get("x"))


def test_variables_have_a_value_before_the_first_message(equip):
    equip(subscribers.ToBlackboard("B", "odom", "odometry", initialise_variables={"odometry": "none"}))

    assert "none" == Blackboard.get("odometry")


def test_an_event_is_on_the_blackboard_for_one_tick(topics, equip):
    leaf = equip(subscribers.EventToBlackboard("E", "odom", "moved"))
    topics.messages["odom"] = at(1.0)
    seen = []
    for _ in range(2):
        leaf.tick_once()
        seen.append(Blackboard.get("moved"))

    assert [True, False] == seen


def test_the_warning_of_a_low_battery_does_not_flicker(topics, equip):
    leaf = equip(battery.ToBlackboard(threshold=30.0))
    warnings = [Blackboard.get("battery_low_warning")]
    for percentage in (0.31, 0.29, 0.34, 0.36, 0.31):
        topics.messages["battery_state"] = BatteryState(percentage=percentage)
        leaf.tick_once()
        warnings.append(Blackboard.get("battery_low_warning"))

    assert [False, False, True, True, False, False] == warnings
    assert BatteryState(percentage=0.31) == Blackboard.get("battery")


@pytest.mark.parametrize(
    ("percentage", "status", "expected"),
    [
        (0.5, BatteryState.POWER_SUPPLY_STATUS_CHARGING, Status.RUNNING),
        (0.9, BatteryState.POWER_SUPPLY_STATUS_CHARGING, Status.SUCCESS),
        (0.89, BatteryState.POWER_SUPPLY_STATUS_FULL, Status.SUCCESS),
        (0.5, BatteryState.POWER_SUPPLY_STATUS_DISCHARGING, Status.FAILURE),
    ],
)
def test_charging_is_waited_for_while_it_goes_on(topics, equip, percentage, status, expected):
    topics.messages["battery_state"] = BatteryState(percentage=percentage, power_supply_status=status)

    assert expected == ticked(equip(battery.WaitUntilCharged(0.9)))


def test_in_lockstep_time_stops_when_a_charge_is_reached_or_ends(topics, equip):
    topics.stops = True
    leaf = equip(battery.WaitUntilCharged(0.9))

    assert [
        Condition("wall_e/battery_state", (("/percentage", ">=", 0.9),)),
        Condition("wall_e/battery_state", (("/power_supply_status", "!=", 1),)),
    ] == leaf.awaited()


@pytest.mark.parametrize(
    ("variable", "value", "compare", "whens"),
    [
        ("percentage", 0.3, operator.lt, [(("/percentage", "<", 0.3),)]),
        ("percentage", 0.3, operator.eq, []),
        ("voltage", 12.0, operator.ge, []),
        ("charge", "full", operator.ge, []),
    ],
)
def test_in_lockstep_time_stops_for_a_level_that_is_compared(topics, equip, variable, value, compare, whens):
    """A level is a formula of time; other fields are polled."""
    topics.stops = True
    leaf = equip(subscribers.CheckData("Level", "battery_state", variable, value, compare))

    assert whens == [each.when for each in leaf.awaited()]


SEEN = Detection3DArray(
    detections=[
        Detection3D(id="eve", results=[ObjectHypothesisWithPose(hypothesis=ObjectHypothesis(class_id="robot"))])
    ]
)


@pytest.mark.parametrize(("entity", "expected"), [("eve", True), ("robot", True), ("wall_e", False)])
def test_what_is_seen_is_a_condition(topics, equip, entity, expected):
    topics.messages["detections"] = SEEN

    assert (Status.SUCCESS if expected else Status.FAILURE) == ticked(equip(detections.IsDetected(entity)))


def test_detections_go_to_the_blackboard(topics, equip):
    topics.messages["detections"] = SEEN
    equip(detections.ToBlackboard()).tick_once()

    assert SEEN == Blackboard.get("detections")


def test_places_go_to_the_blackboard(equip):
    equip(places.ToBlackboard("Places", {"target": "kitchen"})).tick_once()

    assert pose_at(3.0, 4.0) == Blackboard.get("target")


def test_a_place_that_is_not_there_is_an_error_before_the_first_tick(equip):
    with pytest.raises(NotServed, match="'Places': no place 'attic'; there are kitchen"):
        equip(places.ToBlackboard("Places", {"target": "attic"}))
