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


class TestGoalReached:
    """GoalReached compares the robot's position with the goal."""

    @pytest.mark.parametrize(("x", "status"), [(4.74, "F"), (4.75, "S"), (5.0, "S"), (5.25, "S"), (5.26, "F")])
    def test_it_succeeds_within_a_quarter_of_the_unit(self, node, tree, topics, x, status):
        topics.at(x, 1.0)

        assert status == tree(node(GoalReached, goal="5;1"), **topics.known).tick()

    def test_the_robot_may_face_any_way(self, node, tree, topics):
        topics.at(5.0, 1.0, 2.0)

        assert "S" == tree(node(GoalReached, goal="5;1;0"), **topics.known).tick()

    def test_it_watches_the_robots_odometry(self, node, tree, topics):
        tree(node(GoalReached, goal="5;1"), **topics.known)

        assert [("wall_e", "odom")] == topics.watched

    def test_it_has_to_be_looked_at_each_period(self, node, tree, topics):
        """The robot's arrival near the goal is not announced."""
        ticked = tree(node(GoalReached, goal="5;1"), **topics.known)
        ticked.tick()

        assert 1.0 == ticked.due()


class TestGoalUpdated:
    """Another goal than at the last tick."""

    def test_it_fails_when_it_was_idle(self, node, tree, board):
        board["/goal"] = pose_at(1.0, 1.0)
        ticked = tree(node(GoalUpdated))

        assert "FF" == ticked.ticks(0, 1)

    def test_it_succeeds_once_for_each_change(self, node, tree, board):
        ticked = tree(node(GoalUpdated))
        ticked.tick()
        board["/goal"] = pose_at(1.0, 1.0)
        assert "SF" == ticked.ticks(1, 2)
        board["/goals"] = [pose_at(1.0, 1.0)]
        assert "SF" == ticked.ticks(3, 4)

    def test_a_change_while_it_is_idle_is_none(self, node, tree, board):
        ticked = tree(node(GoalUpdated))
        ticked.tick()
        ticked.halt()
        board["/goal"] = pose_at(1.0, 1.0)

        assert "F" == ticked.tick(1)

    def test_a_goal_that_is_text_is_compared_as_a_pose(self, node, tree, board):
        board["/goal"] = "1;1"
        ticked = tree(node(GoalUpdated))
        ticked.tick()
        board["/goal"] = pose_at(1.0, 1.0)

        assert "F" == ticked.tick(1)


class TestGlobalUpdatedGoal:
    """Another goal than ever before."""

    def test_it_succeeds_at_its_first_tick(self, node, tree):
        assert "SF" == tree(node(GlobalUpdatedGoal)).ticks(0, 1)

    def test_a_change_while_it_was_idle_counts(self, node, tree, board):
        ticked = tree(node(GlobalUpdatedGoal))
        ticked.tick()
        ticked.halt()
        board["/goal"] = pose_at(1.0, 1.0)

        assert "SF" == ticked.ticks(1, 2)

    def test_the_port_may_lead_elsewhere(self, node, tree, board):
        ticked = tree(node(GlobalUpdatedGoal, goal="{mine}"))
        ticked.tick()
        board["/goal"] = pose_at(1.0, 1.0)
        assert "F" == ticked.tick(1)
        board["/mine"] = pose_at(1.0, 1.0)
        assert "S" == ticked.tick(2)


class TestIsGoalNearby:
    """IsGoalNearby measures the rest of the path."""

    @pytest.mark.parametrize(("x", "status"), [(0.0, "F"), (6.0, "F"), (6.01, "S"), (10.0, "S")])
    def test_it_succeeds_if_less_than_the_threshold_is_left(self, node, tree, topics, path, x, status):
        """4 m of 10, along the path; the robot need not be on it."""
        topics.at(x, 0.5)
        condition = node(IsGoalNearby, path=path((0, 0), (10, 0)), proximity_threshold="4.0")

        assert status == tree(condition, **topics.known).tick()

    def test_along_the_path_is_not_in_a_straight_line(self, node, tree, topics, path):
        """The goal is 1 m away behind a bend of 9 m."""
        condition = node(IsGoalNearby, path=path((0, 0), (4, 0), (4, 1), (0, 1)), proximity_threshold="2.0")

        assert "F" == tree(condition, **topics.known).tick()

    def test_the_robot_is_looked_for_on_the_whole_path(self, node, tree, topics, path):
        ticked = tree(node(IsGoalNearby, path=path((0, 0), (10, 0), (10, 1), (0, 1))), **topics.known)
        ticked.tick()
        topics.at(0.0, 0.9)

        assert "S" == ticked.tick()

    def test_the_robot_is_looked_for_so_far_ahead_only(self, node, tree, topics, path):
        """A path that comes near itself has two close points; the search stays on the current part."""
        nearby = node(IsGoalNearby, path=path((0, 0), (10, 0), (10, 1), (0, 1)), max_robot_pose_search_dist="1.5")
        ticked = tree(nearby, **topics.known)
        ticked.tick()
        topics.at(0.0, 0.9)

        assert "F" == ticked.tick()

    @pytest.mark.parametrize("ports", [{}, {"path": "{path}"}])
    def test_without_a_path_it_fails(self, node, tree, topics, ports):
        assert "F" == tree(node(IsGoalNearby, **ports), **topics.known).tick()


@pytest.mark.parametrize(("tolerance", "status"), [("4.99", "F"), ("5", "S")])
def test_poses_are_near_within_the_tolerance(node, tree, tolerance, status):
    assert status == tree(node(ArePosesNear, ref_pose="0;0", target_pose="3;4;1", tolerance=tolerance)).tick()


class TestBattery:
    """Conditions on the battery's state."""

    @pytest.fixture
    def battery(self, topics):
        """Return the function that sets the battery's message."""

        def tell(**fields):
            topics.messages["battery_state"] = BatteryState(**fields)
            return topics.known

        return tell

    @pytest.mark.parametrize(("left", "status"), [(0.31, "F"), (0.3, "S"), (0.0, "S")])
    def test_it_is_low_at_the_share_or_below(self, node, tree, battery, left, status):
        """The share is from 0 to 1, as in BatteryState."""
        assert status == tree(node(IsBatteryLow, min_battery="0.3"), **battery(percentage=left)).tick()

    @pytest.mark.parametrize(("volts", "status"), [(11.6, "F"), (11.5, "S")])
    def test_it_is_low_at_the_voltage_or_below(self, node, tree, battery, volts, status):
        low = node(IsBatteryLow, min_battery="11.5", is_voltage="true")

        assert status == tree(low, **battery(voltage=volts, percentage=0.9)).tick()

    @pytest.mark.parametrize(("state", "status"), [(1, "S"), (2, "F"), (3, "F"), (4, "F")])
    def test_it_is_charging_if_it_says_so(self, node, tree, battery, state, status):
        """CHARGING is 1; a full battery is not charging."""
        assert status == tree(node(IsBatteryCharging), **battery(power_supply_status=state)).tick()

    @pytest.mark.parametrize(("left", "operator"), [(0.31, "<="), (0.3, ">")])
    def test_in_lockstep_time_stops_for_the_other_verdict(self, node, tree, topics, battery, left, operator):
        topics.stops = True
        low = tree(node(IsBatteryLow, min_battery="0.3"), **battery(percentage=left))
        low.tick()

        assert (math.inf, [("wall_e/battery_state", "/percentage", operator, 0.3)]) == (low.due(), low.awaited())

    @pytest.mark.parametrize(("state", "operator"), [(1, "!="), (2, "==")])
    def test_in_lockstep_time_stops_when_charging_begins_or_ends(self, node, tree, topics, battery, state, operator):
        topics.stops = True
        charging = tree(node(IsBatteryCharging), **battery(power_supply_status=state))
        charging.tick()

        assert [("wall_e/battery_state", "/power_supply_status", operator, 1)] == charging.awaited()

    def test_a_voltage_is_polled(self, node, tree, topics, battery):
        topics.stops = True
        low = tree(node(IsBatteryLow, min_battery="11.5", is_voltage="true"), **battery(voltage=12.0))
        low.tick()

        assert (1.0, []) == (low.due(), low.awaited())

    def test_without_lockstep_a_battery_is_polled(self, node, tree, battery):
        low = tree(node(IsBatteryLow, min_battery="0.3"), **battery(percentage=0.5))
        low.tick()

        assert (1.0, []) == (low.due(), low.awaited())

    @pytest.mark.parametrize("topic", ["/wall_e/battery_state", "battery_state", "/battery_status"])
    def test_the_topic_may_be_named(self, node, tree, battery, topic):
        low = node(IsBatteryLow, min_battery="0.3", battery_topic=topic)

        assert "F" == tree(low, **battery(percentage=0.5)).tick()

    @pytest.mark.parametrize("topic", ["eve/battery_state", "/eve/battery_state"])
    def test_the_battery_of_another_robot(self, node, tree, battery, topics, topic):
        low = tree(node(IsBatteryLow, min_battery="0.3", battery_topic=topic), **battery(percentage=0.2))

        assert [("eve", "battery_state")] == topics.watched
        assert "S" == low.tick()

    def test_another_topic_is_refused(self, node, tree, battery):
        low = node(IsBatteryLow, min_battery="0.3", battery_topic="/battery")

        with pytest.raises(PortError, match=r"no topic '/battery'; the battery state is on 'battery_state'"):
            tree(low, **battery())

    def test_another_topic_is_an_error_when_a_file_is_read(self, tmp_path):
        path = tmp_path / "low.xml"
        path.write_text(
            '<root BTCPP_format="4"><BehaviorTree ID="Low"><IsBatteryLow min_battery="0.3" battery_topic="low"/>'
            "</BehaviorTree></root>"
        )
        with pytest.raises(TreeError, match=r"low.xml:1: <IsBatteryLow>: port 'battery_topic': no topic 'low'"):
            load(str(path))


class TestDistanceTraveled:
    """DistanceTraveled measures the distance from an earlier position."""

    def test_it_succeeds_each_time_the_robot_has_come_so_far(self, node, tree, topics):
        ticked = tree(node(DistanceTraveled, distance="2.0"), **topics.known)
        statuses = []
        for x in (0.0, 1.9, 2.1, 4.0, 4.2):
            topics.at(x, 0.0)
            statuses.append(ticked.tick())

        assert list("FFSFS") == statuses


class TestIsStopped:
    """IsStopped succeeds after a robot was slow for a while."""

    def test_it_runs_until_the_robot_has_stood_long_enough(self, node, tree, topics):
        ticked = tree(node(IsStopped), **topics.known)

        assert "RRS" == ticked.ticks(0, 0.9, 1.0)

    def test_it_fails_while_the_robot_moves(self, node, tree, topics):
        ticked = tree(node(IsStopped, velocity_threshold="0.1", duration_stopped="500"), **topics.known)
        ticked.tick(0.0)
        topics.at(0.0, 0.0, speed=0.1)
        assert "F" == ticked.tick(0.4)
        topics.at(0.0, 0.0, speed=0.09)
        assert "RRS" == ticked.ticks(0.5, 0.9, 1.0)

    def test_it_has_to_be_looked_at_each_period(self, node, tree, topics):
        """The robot may drive before the time is over, and this is not announced."""
        ticked = tree(node(IsStopped, duration_stopped="10000"), **topics.known)
        ticked.tick()

        assert 1.0 == ticked.due()

    def test_it_counts_anew_after_a_success(self, node, tree, topics):
        ticked = tree(node(IsStopped), **topics.known)

        assert "RSRS" == ticked.ticks(0.0, 1.0, 100.0, 101.0)

    def test_it_counts_anew_after_a_halt(self, node, tree, topics):
        """The robot may have driven meanwhile."""
        ticked = tree(node(IsStopped), **topics.known)
        ticked.tick(0.0)
        ticked.halt()

        assert "RS" == ticked.ticks(100.0, 101.0)

    def test_it_has_an_older_name_too(self):
        assert "CheckStopStatus" == registry()["CheckStopStatus"].__name__


class TestIsStuck:
    """Braking like into a wall."""

    def test_it_succeeds_if_the_robot_has_braked_too_hard(self, node, tree, topics):
        """2 m/s lost in 0.1 s; the next time it stands, and is not stuck."""
        ticked = tree(node(IsStuck), **topics.known)
        statuses = []
        for seconds, speed in ((1.0, 2.0), (1.1, 0.0), (1.2, 0.0)):
            topics.at(0.0, 0.0, speed=speed, seconds=seconds)
            statuses.append(ticked.tick())

        assert list("FSF") == statuses

    def test_braking_as_one_does_is_not_being_stuck(self, node, tree, topics):
        ticked = tree(node(IsStuck), **topics.known)
        topics.at(0.0, 0.0, speed=2.0, seconds=1.0)
        ticked.tick()
        topics.at(0.0, 0.0, speed=0.0, seconds=2.0)

        assert "F" == ticked.tick()

    def test_the_same_message_again_has_no_effect(self, node, tree, topics):
        assert "FF" == tree(node(IsStuck), **topics.known).ticks(0, 1)


class TestTimeExpired:
    """TimeExpired succeeds at regular intervals."""

    def test_it_succeeds_each_time_so_many_seconds_are_over(self, node, tree):
        assert "FFSFS" == tree(node(TimeExpired, seconds="2.0")).ticks(0, 1.9, 2.5, 4.4, 4.5)

    def test_a_reset_begins_anew(self, node, tree):
        ticked = tree(node(TimeExpired, seconds="2.0"))
        ticked.tick(0)
        ticked.halt()

        assert "FS" == ticked.ticks(1.9, 3.9)

    def test_it_looks_again_when_the_time_is_over(self, node, tree):
        ticked = tree(node(TimeExpired, seconds="2.5"))
        ticked.tick(1.0)

        assert 3.5 == ticked.due()


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
