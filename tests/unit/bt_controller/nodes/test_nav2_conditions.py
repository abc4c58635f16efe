"""Nav2's conditions: what their documentation says, sentence by sentence."""

from __future__ import annotations

import math

import pytest
from py_trees.common import Status

from bt_controller.core.node import PortError
from bt_controller.errors import TreeError
from bt_controller.loading.trees import load
from bt_controller.nodes import registry
from bt_controller.nodes.conditions.blackboard import (
    AreErrorCodesPresent,
    WouldAControllerRecoveryHelp,
    WouldAPlannerRecoveryHelp,
    WouldARouteRecoveryHelp,
    WouldASmootherRecoveryHelp,
)
from bt_controller.nodes.conditions.goals import (
    ArePosesNear,
    GlobalUpdatedGoal,
    GoalReached,
    GoalUpdated,
    IsGoalNearby,
    IsWithinPathTrackingBounds,
)
from bt_controller.nodes.conditions.robot import (
    DistanceTraveled,
    InitialPoseReceived,
    IsBatteryCharging,
    IsBatteryLow,
    IsStopped,
    IsStuck,
    PathExpiringTimer,
    TimeExpired,
    TransformAvailable,
)
from hmrsim.interfaces.nav2_msgs import TrackingFeedback
from hmrsim.interfaces.sensor_msgs import BatteryState
from hmrsim_zenoh.client.places import pose_at
from tests.unit.bt_controller.nodes.conftest import At, Row, rows

HERE = pose_at(1.0, 1.0)


@pytest.mark.parametrize(("x", "status"), [(4.74, "F"), (4.75, "S"), (5.0, "S"), (5.25, "S"), (5.26, "F")])
def test_a_goal_is_reached_within_a_quarter_of_the_unit(behaves, x, status):
    behaves(Row(GoalReached, "", status, {"goal": "5;1"}, at=At(x, 1.0)))


def test_goal_reached_watches_the_robots_odometry(node, tree, topics):
    tree(node(GoalReached, goal="5;1"), **topics.known)

    assert [("wall_e", "odom")] == topics.watched


@rows(
    {
        "the goal is reached whatever way the robot faces": Row(
            GoalReached, "", "S", {"goal": "5;1;0"}, at=At(5.0, 1.0, 2.0)
        ),
        "the robot's arrival is not announced": Row(GoalReached, "", "F", {"goal": "5;1"}, due=1.0),
        "the first goal is no update": Row(GoalUpdated, "", "FF", before={"goal": HERE}),
        "each change of a goal is one update": Row(
            GoalUpdated, "", ["F", {"goal": HERE}, "SF", {"goals": [HERE]}, "SF"]
        ),
        "a change while it is idle is no update": Row(GoalUpdated, "", ["F!", {"goal": HERE}, "F"]),
        "a goal that is text is compared as a pose": Row(
            GoalUpdated, "", ["F", {"goal": HERE}, "F"], before={"goal": "1;1"}
        ),
        "the first tick is a global update": Row(GlobalUpdatedGoal, "", "SF"),
        "a change while it was idle is a global update": Row(GlobalUpdatedGoal, "", ["S!", {"goal": HERE}, "SF"]),
        "the port may lead elsewhere": Row(
            GlobalUpdatedGoal, "", ["S", {"goal": HERE}, "F", {"mine": HERE}, "S"], {"goal": "{mine}"}
        ),
    }
)
def test_conditions_on_goals(behaves, row):
    behaves(row)


STRAIGHT, ROUND = [(0, 0), (10, 0)], [(0, 0), (10, 0), (10, 1), (0, 1)]
FOUR = {"proximity_threshold": "4.0"}


@pytest.mark.parametrize(
    ("points", "ports", "at", "steps"),
    [
        (STRAIGHT, FOUR, At(0.0, 0.5), "F"),
        (STRAIGHT, FOUR, At(6.0, 0.5), "F"),
        (STRAIGHT, FOUR, At(6.01, 0.5), "S"),
        (STRAIGHT, FOUR, At(10.0, 0.5), "S"),
        ([(0, 0), (4, 0), (4, 1), (0, 1)], FOUR, At(), "F"),
        (ROUND, {}, At(), ["F", At(0.0, 0.9), "S"]),
        (ROUND, {"max_robot_pose_search_dist": "1.5"}, At(), ["F", At(0.0, 0.9), "F"]),
    ],
    ids=[
        "at the start",
        "as much left as the threshold",
        "less left than the threshold",
        "at the goal",
        "1 m away behind a bend of 9 m",
        "looked for on the whole path",
        "looked for on the current part, as the path comes near itself",
    ],
)
def test_a_goal_is_nearby_along_the_path(behaves, path, points, ports, at, steps):
    behaves(Row(IsGoalNearby, "", steps, {"path": path(*points), **ports}, at=at))


@pytest.mark.parametrize("ports", [{}, {"path": "{path}"}])
def test_no_goal_is_nearby_without_a_path(behaves, ports):
    behaves(Row(IsGoalNearby, "", "F", ports))


@pytest.mark.parametrize(("tolerance", "status"), [("4.99", "F"), ("5", "S")])
def test_poses_are_near_within_the_tolerance(node, tree, tolerance, status):
    assert status == tree(node(ArePosesNear, ref_pose="0;0", target_pose="3;4;1", tolerance=tolerance)).tick()


SHARE, VOLTS = {"min_battery": "0.3"}, {"min_battery": "11.5", "is_voltage": "true"}
CHARGING, DISCHARGING = {"power_supply_status": 1}, {"power_supply_status": 2}


class TestBattery:
    """Conditions on the battery's state."""

    @pytest.fixture
    def battery(self, node, tree, topics):
        """Return what makes a tree of a condition on a battery with this message."""

        def make(kind, ports, fields, *, stops=False):
            topics.messages["battery_state"] = BatteryState(**fields)
            topics.stops = stops
            return tree(node(kind, **ports), **topics.known)

        return make

    @pytest.mark.parametrize(
        ("kind", "ports", "fields", "status"),
        [
            (IsBatteryLow, SHARE, {"percentage": 0.31}, "F"),
            (IsBatteryLow, SHARE, {"percentage": 0.3}, "S"),
            (IsBatteryLow, SHARE, {"percentage": 0.0}, "S"),
            (IsBatteryLow, VOLTS, {"voltage": 11.6, "percentage": 0.9}, "F"),
            (IsBatteryLow, VOLTS, {"voltage": 11.5, "percentage": 0.9}, "S"),
            (IsBatteryCharging, {}, CHARGING, "S"),
            (IsBatteryCharging, {}, DISCHARGING, "F"),
            (IsBatteryCharging, {}, {"power_supply_status": 3}, "F"),
            (IsBatteryCharging, {}, {"power_supply_status": 4}, "F"),
            (IsBatteryLow, {**SHARE, "battery_topic": "/wall_e/battery_state"}, {"percentage": 0.5}, "F"),
            (IsBatteryLow, {**SHARE, "battery_topic": "battery_state"}, {"percentage": 0.5}, "F"),
            (IsBatteryLow, {**SHARE, "battery_topic": "/battery_status"}, {"percentage": 0.5}, "F"),
        ],
    )
    def test_the_message_decides(self, battery, kind, ports, fields, status):
        """Shares are from 0 to 1, CHARGING is 1, and a full battery is not charging."""
        assert status == battery(kind, ports, fields).tick()

    @pytest.mark.parametrize(
        ("kind", "ports", "fields", "stops", "due", "awaited"),
        [
            (IsBatteryLow, SHARE, {"percentage": 0.31}, True, math.inf, [("/percentage", "<=", 0.3)]),
            (IsBatteryLow, SHARE, {"percentage": 0.3}, True, math.inf, [("/percentage", ">", 0.3)]),
            (IsBatteryLow, SHARE, {"percentage": 0.5}, False, 1.0, []),
            (IsBatteryLow, VOLTS, {"voltage": 12.0}, True, 1.0, []),
            (IsBatteryCharging, {}, CHARGING, True, math.inf, [("/power_supply_status", "!=", 1)]),
            (IsBatteryCharging, {}, DISCHARGING, True, math.inf, [("/power_supply_status", "==", 1)]),
        ],
    )
    def test_in_lockstep_time_stops_for_the_other_verdict(self, battery, kind, ports, fields, stops, due, awaited):
        """Voltages are polled, and everything is without lockstep."""
        condition = battery(kind, ports, fields, stops=stops)
        condition.tick()

        assert (due, [("wall_e/battery_state", *each) for each in awaited]) == (condition.due(), condition.awaited())

    @pytest.mark.parametrize("topic", ["eve/battery_state", "/eve/battery_state"])
    def test_the_battery_of_another_robot(self, battery, topics, topic):
        low = battery(IsBatteryLow, {**SHARE, "battery_topic": topic}, {"percentage": 0.2})

        assert [("eve", "battery_state")] == topics.watched
        assert "S" == low.tick()

    def test_another_topic_is_refused(self, battery):
        with pytest.raises(PortError, match=r"no topic '/battery'; the battery state is on 'battery_state'"):
            battery(IsBatteryLow, {**SHARE, "battery_topic": "/battery"}, {})

    def test_another_topic_is_an_error_when_a_file_is_read(self, tmp_path):
        path = tmp_path / "low.xml"
        path.write_text(
            '<root BTCPP_format="4"><BehaviorTree ID="Low"><IsBatteryLow min_battery="0.3" battery_topic="low"/>'
            "</BehaviorTree></root>"
        )
        with pytest.raises(TreeError, match=r"low.xml:1: <IsBatteryLow>: port 'battery_topic': no topic 'low'"):
            load(str(path))


@rows(
    {
        "it succeeds each time the robot has come so far": Row(
            DistanceTraveled,
            "",
            ["F", At(1.9), "F", At(2.1), "S", At(4.0), "F", At(4.2), "S"],
            {"distance": "2.0"},
        ),
        "it runs until the robot has stood long enough": Row(IsStopped, "", "RRS", times=(0, 0.9, 1.0)),
        "it fails while the robot moves": Row(
            IsStopped,
            "",
            ["R", At(speed=0.1), "F", At(speed=0.09), "RRS"],
            {"velocity_threshold": "0.1", "duration_stopped": "500"},
            (0.0, 0.4, 0.5, 0.9, 1.0),
        ),
        "the robot may drive before the time is over": Row(IsStopped, "", "R", {"duration_stopped": "10000"}, due=1.0),
        "it counts anew after a success": Row(IsStopped, "", "RSRS", times=(0.0, 1.0, 100.0, 101.0)),
        "it counts anew after a halt": Row(IsStopped, "", "R!RS", times=(0.0, 100.0, 101.0)),
        "2 m/s lost in 0.1 s are being stuck, and standing is not": Row(
            IsStuck,
            "",
            ["F", At(seconds=1.1), "S", At(seconds=1.2), "F"],
            at=At(speed=2.0, seconds=1.0),
        ),
        "2 m/s lost in a second are not being stuck": Row(
            IsStuck, "", ["F", At(seconds=2.0), "F"], at=At(speed=2.0, seconds=1.0)
        ),
        "the same message again has no effect": Row(IsStuck, "", "FF"),
        "it succeeds each time so many seconds are over": Row(
            TimeExpired, "", "FFSFS", {"seconds": "2.0"}, (0, 1.9, 2.5, 4.4, 4.5)
        ),
        "a reset begins anew": Row(TimeExpired, "", "F!FS", {"seconds": "2.0"}, (0, 1.9, 3.9)),
        "it looks again when the time is over": Row(TimeExpired, "", "F", {"seconds": "2.5"}, (1.0,), due=3.5),
    }
)
def test_conditions_on_motion_and_time(behaves, row):
    behaves(row)


def test_is_stopped_has_an_older_name_too():
    assert "CheckStopStatus" == registry()["CheckStopStatus"].__name__


class TestPathExpiringTimer:
    """PathExpiringTimer measures the age of a path."""

    def test_it_succeeds_each_time_so_many_seconds_are_over(self, node, tree, path):
        ticked = tree(node(PathExpiringTimer, path=path((0, 0), (1, 0))))
        ticked.tick(0)
        ticked.halt()

        assert "FSFS" == ticked.ticks(0.9, 1.0, 1.9, 2.0)

    def test_another_path_begins_the_time_anew(self, node, tree, path, board):
        board["/path"] = path((0, 0), (1, 0))
        ticked = tree(node(PathExpiringTimer, path="{path}"))
        ticked.tick(0)
        board["/path"] = path((0, 0), (2, 0))

        assert "FFS" == ticked.ticks(0.9, 1.8, 1.9)
        assert pytest.approx(2.9) == ticked.due(period=100.0)


class TestErrorCodes:
    """Conditions on error codes select codes by meaning."""

    @pytest.mark.parametrize(("code", "status"), [(100, "F"), (106, "S"), (208, "S"), (0, "F")])
    def test_the_codes_to_look_for_are_written_with_semicolons(self, node, tree, code, status):
        assert status == tree(node(AreErrorCodesPresent, error_code=code, error_codes_to_check="106;208")).tick()

    @pytest.mark.parametrize(
        ("kind", "codes"),
        [
            (WouldAPlannerRecoveryHelp, [200, 207, 208]),
            (WouldAControllerRecoveryHelp, [100, 104, 105, 106]),
            (WouldASmootherRecoveryHelp, [500, 502, 503, 504]),
            (WouldARouteRecoveryHelp, [400, 404, 405]),
        ],
    )
    def test_a_recovery_helps_against_some_causes(self, node, tree, kind, codes):
        """As Nav2 has it: not if the goal is outside the map, or occupied."""
        helped = [
            code
            for code in (0, 1, 2, *range(100, 110), *range(200, 210), *range(400, 408), *range(500, 506))
            if tree(node(kind, error_code=code)).tick() == "S"
        ]

        assert codes == helped

    def test_other_codes_can_be_named(self, node, tree):
        codes = {"error_codes_to_check": "204;206"}

        assert "S" == tree(node(WouldAPlannerRecoveryHelp, error_code=204, **codes)).tick()
        assert "F" == tree(node(WouldAPlannerRecoveryHelp, error_code=208, **codes)).tick()

    def test_a_code_that_was_never_written_is_none(self, node, tree):
        assert "F" == tree(node(WouldAControllerRecoveryHelp, error_code="{never}")).tick()


class TestIsWithinPathTrackingBounds:
    """IsWithinPathTrackingBounds compares tracking errors with bounds."""

    @pytest.mark.parametrize(
        ("aside", "turned", "status"),
        [(0.2, 0.0, "S"), (0.21, 0.0, "F"), (-0.4, 0.0, "S"), (-0.41, 0.0, "F"), (0.0, -1.0, "S"), (0.0, 1.1, "F")],
    )
    def test_each_side_has_a_bound(self, node, tree, aside, turned, status):
        """0.2 to the left, 0.4 to the right, a radian either way; the signs of bounds do not matter."""
        tracking = TrackingFeedback(position_tracking_error=aside, heading_tracking_error=turned)
        bounds = {"max_error_left": "0.2", "max_error_right": "-0.4", "max_error_heading": "1.0"}

        assert status == tree(node(IsWithinPathTrackingBounds, tracking_feedback=tracking, **bounds)).tick()

    def test_a_robot_that_follows_no_path_is_within(self, node, tree):
        assert "S" == tree(node(IsWithinPathTrackingBounds, tracking_feedback="{never}")).tick()


class TestLocalisation:
    """Robots here know where they are."""

    def test_the_initial_pose_was_received(self, node, tree):
        assert "S" == tree(node(InitialPoseReceived)).tick()
        assert "F" == tree(node(InitialPoseReceived, initial_pose_received="false")).tick()

    @pytest.mark.parametrize(("child", "status"), [("base_link", "S"), ("odom", "F")])
    def test_two_frames_are_known(self, node, tree, child, status):
        ticked = tree(node(TransformAvailable, child=child, parent="map"))

        assert status == ticked.tick()
        assert ("" if status == "S" else "no frame 'odom'; there are map and base_link") == ticked.root.feedback_message


def test_conditions_never_run_but_for_one(node, tree, topics):
    topics.messages["battery_state"] = BatteryState(percentage=0.5)
    ports = {
        AreErrorCodesPresent: {"error_codes_to_check": "1"},
        ArePosesNear: {"ref_pose": "0;0", "target_pose": "0;0"},
        GoalReached: {"goal": "0;0"},
        IsBatteryLow: {"min_battery": "0.1"},
    }
    kinds = [*ports, DistanceTraveled, GlobalUpdatedGoal, GoalUpdated, IsGoalNearby, IsStuck, TimeExpired]
    trees = [tree(node(kind, **ports.get(kind, {})), **topics.known) for kind in kinds]
    for each in trees:
        each.tick()

    assert Status.RUNNING not in [each.root.status for each in trees]
