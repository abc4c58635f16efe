"""Nav2's actions that take no time: paths, poses, goals, cancels, and what there is nothing to do for."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest

from bt_controller.core.robots import Directory
from bt_controller.nodes import registry
from bt_controller.nodes.actions.paths import (
    AppendGoalPoseToGoals,
    ConcatenatePaths,
    GetCurrentPose,
    GetNextFewGoals,
    GetPoseFromPath,
    RemovePassedGoals,
    TruncatePath,
    TruncatePathLocal,
)
from bt_controller.nodes.actions.routes import ExtractRouteNodesAsGoals
from bt_controller.nodes.controls.nav2 import PipelineSequence
from bt_controller.nodes.controls.sequences import ReactiveSequence
from bt_controller.nodes.poses import point_of, yaw_at
from hmrsim.interfaces.geometry_msgs import Point
from hmrsim.interfaces.nav2_msgs import Route, RouteNode, WaypointStatus
from hmrsim.interfaces.nav_msgs import Path
from hmrsim.interfaces.std_msgs import Header
from hmrsim_zenoh.client.places import pose_at
from hmrsim_zenoh.errors import RequestTimeout


def points(path):
    return [point_of(pose) for pose in path.poses]


class TestTruncatePath:
    """A path without its end."""

    @pytest.mark.parametrize(
        ("distance", "expected"),
        [
            ({}, [(0, 0), (4, 0), (4, 2)]),
            ({"distance": "3"}, [(0, 0), (4, 0)]),
            ({"distance": "5"}, [(0, 0), (2, 0)]),
            ({"distance": "9"}, [(0, 0)]),
        ],
    )
    def test_it_ends_so_far_before_the_goal(self, node, tree, path, board, distance, expected):
        ticked = tree(node(TruncatePath, input_path=path((0, 0), (4, 0), (4, 3)), output_path="{out}", **distance))

        assert "S" == ticked.tick()
        assert expected == points(board["/out"])

    def test_its_last_pose_faces_the_goal(self, node, tree, path, board):
        cut = node(TruncatePath, input_path=path((0, 0), (4, 0), (4, 2)), distance="4", output_path="{out}")
        tree(cut).tick()

        assert math.pi / 4 == pytest.approx(yaw_at(board["/out"].poses[-1]))

    def test_an_empty_path_stays_empty(self, node, tree, board):
        assert "S" == tree(node(TruncatePath, input_path="{path}", output_path="{out}")).tick()
        assert Path() == board["/out"]


class TestTruncatePathLocal:
    """The part of a path around the robot."""

    @pytest.fixture
    def cut(self, node, tree, topics, board, path):
        """Return the function that cuts the path from (0, 0) to (20, 0) around (10, 1): the points of the part."""

        def run(**ports):
            topics.at(10.0, 1.0)
            part = node(TruncatePathLocal, input_path=path((0, 0), (20, 0)), output_path="{out}", **ports)
            assert "S" == tree(part, **topics.known).tick()
            return points(board["/out"])

        return run

    def test_it_is_so_long_before_and_behind_the_robot(self, cut):
        assert [(6, 0), (18, 0)] == cut()
        assert [(9, 0), (12, 0)] == cut(distance_forward="2", distance_backward="1")

    def test_it_adds_nothing_to_the_ends_of_the_path(self, cut):
        assert [(0, 0), (20, 0)] == cut(distance_forward="99", distance_backward="99")

    def test_a_negative_distance_is_all_that_comes(self, cut):
        """As Nav2's default tree wants it."""
        assert [(10, 0), (20, 0)] == cut(distance_forward="-1", distance_backward="0.0")

    def test_another_pose_may_take_the_robots_place(self, cut):
        assert [(3, 0), (4, 0)] == cut(pose="3;5", distance_forward="1", distance_backward="0")

    def test_poses_where_the_path_bends_are_kept(self, node, tree, topics, board, path):
        way = path((0, 0), (4, 0), (4, 4), (0, 4))
        tree(node(TruncatePathLocal, input_path=way, output_path="{out}", distance_forward="6"), **topics.known).tick()

        assert way.poses[:2] == board["/out"].poses[:2]
        assert [(0, 0), (4, 0), (4, 2)] == points(board["/out"])

    def test_the_robots_heading_may_count(self, node, tree, topics, board, path):
        """There and back: a robot that faces back is on the way back."""
        topics.at(5.0, 0.1, math.pi)
        ports = {"angular_distance_weight": "1.0", "distance_forward": "1", "distance_backward": "0"}
        there_and_back = path((0, 0), (10, 0), (10, 0.2), (0, 0.2))
        tree(node(TruncatePathLocal, input_path=there_and_back, output_path="{out}", **ports), **topics.known).tick()

        assert [(5, 0.2), (4, 0.2)] == points(board["/out"])

    def test_the_robot_may_be_looked_for_so_far_ahead_only(self, node, tree, topics, board, path):
        board["/path"] = path((0, 0), (10, 0), (10, 1), (0, 1))
        ports = {"max_robot_pose_search_dist": "2", "distance_forward": "1", "distance_backward": "0"}
        part = node(TruncatePathLocal, input_path="{path}", output_path="{out}", **ports)
        ticked = tree(part, **topics.known)
        ticked.tick()
        topics.at(1.0, 0.9)
        ticked.tick()
        assert [(1, 0), (2, 0)] == points(board["/out"])
        board["/path"] = path((10, 1), (0, 1))
        topics.at(9.0, 0.9)
        ticked.tick()
        assert [(9, 1), (8, 1)] == points(board["/out"])

    def test_an_empty_path_stays_empty(self, node, tree, topics, board):
        ticked = tree(node(TruncatePathLocal, input_path="{path}", output_path="{out}"), **topics.known)

        assert "S" == ticked.tick()
        assert Path() == board["/out"]


class TestConcatenatePaths:
    """One path after the other."""

    def test_the_second_path_comes_after_the_first(self, node, tree, path, board):
        both = {"input_path1": path((0, 0), (1, 0)), "input_path2": path((1, 0), (1, 1))}
        tree(node(ConcatenatePaths, output_path="{out}", **both)).tick()

        assert [(0, 0), (1, 0), (1, 0), (1, 1)] == points(board["/out"])

    def test_the_header_is_the_firsts_if_it_has_one(self, node, tree, path, board):
        first, second = Path(), path((1, 0)).model_copy(update={"header": Header(frame_id="map")})
        tree(node(ConcatenatePaths, output_path="{out}", input_path1=first, input_path2=second)).tick()

        assert "map" == board["/out"].header.frame_id

    def test_without_any_pose_it_fails(self, node, tree):
        assert "F" == tree(node(ConcatenatePaths, input_path1=Path())).tick()


class TestGetPoseFromPath:
    """One pose of a path."""

    @pytest.mark.parametrize(("index", "x"), [({}, 0.0), ({"index": "-1"}, 2.0), ({"index": "-2"}, 1.0)])
    def test_the_index_counts_from_either_end(self, node, tree, path, board, index, x):
        assert "S" == tree(node(GetPoseFromPath, path=path((0, 0), (1, 0), (2, 0)), pose="{pose}", **index)).tick()
        assert x == board["/pose"].pose.position.x

    @pytest.mark.parametrize("index", ["2", "-3"])
    def test_a_pose_that_is_not_there_is_a_failure(self, node, tree, path, index):
        ticked = tree(node(GetPoseFromPath, path=path((0, 0), (1, 0)), index=index))

        assert "F" == ticked.tick()
        assert f"no pose {index} in a path of 2" == ticked.root.feedback_message

    def test_a_pose_without_a_frame_gets_the_paths(self, node, tree, path, board):
        way = path((0, 0)).model_copy(update={"header": Header(frame_id="map")})
        tree(node(GetPoseFromPath, path=way, pose="{pose}")).tick()

        assert "map" == board["/pose"].header.frame_id


def test_the_current_pose_is_the_odometrys(node, tree, topics, board):
    topics.at(3.0, 4.0, 1.0)
    tree(node(GetCurrentPose, current_pose="{pose}"), **topics.known).tick()

    assert pose_at(3.0, 4.0, 1.0).pose == board["/pose"].pose
    assert "map" == board["/pose"].header.frame_id


class TestRemovePassedGoals:
    """RemovePassedGoals removes goals that the robot has passed."""

    GOALS = "1;0|2;0|3;0|1;0"

    def test_the_first_goals_within_the_radius_are_left_out(self, node, tree, topics, board):
        topics.at(1.4, 0.0)
        ports = {"input_goals": self.GOALS, "output_goals": "{out}", "radius": "0.5", "global_frame": "map"}
        tree(node(RemovePassedGoals, **ports), **topics.known).tick()

        assert [2.0, 3.0, 1.0] == [goal.pose.position.x for goal in board["/out"]]

    def test_the_last_goal_always_stays(self, node, tree, topics, board):
        """The action that drives there says when the last goal is reached."""
        tree(node(RemovePassedGoals, input_goals="0;0|0;0", output_goals="{out}"), **topics.known).tick()

        assert 1 == len(board["/out"])

    def test_its_waypoint_is_completed(self, node, tree, topics, board):
        topics.at(1.0, 0.0)
        pose = pose_at(1.0, 0.0)
        statuses = [
            WaypointStatus(waypoint_pose=pose, waypoint_status=WaypointStatus.SKIPPED),
            WaypointStatus(waypoint_pose=pose),
            WaypointStatus(waypoint_pose=pose_at(2.0, 0.0)),
        ]
        board["/before"] = statuses
        names = {"input_waypoint_statuses": "{before}", "output_waypoint_statuses": "{after}"}
        tree(node(RemovePassedGoals, input_goals=self.GOALS, **names), **topics.known).tick()

        assert [2, 1, 0] == [status.waypoint_status for status in board["/after"]]


def test_a_goal_is_added_at_the_end(node, tree, board):
    tree(node(AppendGoalPoseToGoals, input_goals="1;0|2;0", goal_pose="3;0", output_goals="{out}")).tick()

    assert [1.0, 2.0, 3.0] == [goal.pose.position.x for goal in board["/out"]]


def test_the_waypoints_of_a_route_are_goals(node, tree, board):
    header = Header(frame_id="map")
    nodes = [RouteNode(nodeid=7, position=Point(x=1.0)), RouteNode(nodeid=2, position=Point(y=2.0))]
    route = Route(header=header, nodes=nodes)

    assert "S" == tree(node(ExtractRouteNodesAsGoals, route=route, goals="{out}")).tick()
    assert [(1.0, 0.0), (0.0, 2.0)] == [(at.pose.position.x, at.pose.position.y) for at in board["/out"]]
    assert "map" == board["/out"][0].header.frame_id
    empty = tree(node(ExtractRouteNodesAsGoals, route=Route(), goals="{out}"))
    assert ("F", "the route has no waypoints") == (empty.tick(), empty.root.feedback_message)


class TestGetNextFewGoals:
    """GetNextFewGoals writes the first goals."""

    @pytest.mark.parametrize(("count", "expected"), [("2", [1.0, 2.0]), ("9", [1.0, 2.0, 3.0])])
    def test_so_many_or_all(self, node, tree, board, count, expected):
        tree(node(GetNextFewGoals, input_goals="1;0|2;0|3;0", num_goals=count, output_goals="{out}")).tick()

        assert expected == [goal.pose.position.x for goal in board["/out"]]

    def test_without_goals_it_fails(self, node, tree):
        assert "F" == tree(node(GetNextFewGoals, input_goals=[], num_goals="1")).tick()


@pytest.mark.parametrize("control", [ReactiveSequence, PipelineSequence])
@pytest.mark.parametrize(
    ("kind", "ports"),
    [(GetCurrentPose, {}), (RemovePassedGoals, {"input_goals": "1;0|2;0"}), (TruncatePathLocal, {})],
)
def test_what_looks_where_the_robot_is_looks_again_each_period(node, tree, told, topics, control, kind, ports):
    """The robot's progress is not announced while another node runs."""
    ticked = tree(node(control, node(kind, **ports), told("R")), **topics.known)
    ticked.tick()

    assert 1.0 == ticked.due()


class TestCancels:
    """All goals of an action."""

    @pytest.fixture
    def asked(self):
        """Return what nodes are set up with; its client keeps the cancel requests."""

        class Client:
            def __init__(self):
                self.requests = []
                self.error = None

            def action_client(self, robot, action):
                return SimpleNamespace(cancel_all=lambda: self.cancel_all(f"{robot}/{action.name}"))

            def cancel_all(self, name):
                self.requests.append(name)
                if self.error:
                    raise self.error

        actions = ["back_up", "drive_on_heading", "follow_path", "spin", "wait"]
        directory = Directory.from_info({"robots": [{"name": "wall_e", "actions": actions}]})
        return {"client": Client(), "robot": "wall_e", "directory": directory}

    @pytest.mark.parametrize(
        ("tag", "action"),
        [
            ("CancelBackUp", "back_up"),
            ("CancelControl", "follow_path"),
            ("CancelDriveOnHeading", "drive_on_heading"),
            ("CancelSpin", "spin"),
            ("CancelWait", "wait"),
        ],
    )
    def test_the_robot_is_asked_to_cancel_all_goals_of_the_action(self, node, tree, asked, tag, action):
        assert "S" == tree(node(registry()[tag]), **asked).tick()
        assert [f"wall_e/{action}"] == asked["client"].requests

    def test_a_robot_that_does_not_answer_is_a_failure(self, node, tree, asked):
        asked["client"].error = RequestTimeout("no answer")
        ticked = tree(node(registry()["CancelControl"]), **asked)

        assert "F" == ticked.tick()
        assert "no answer" == ticked.root.feedback_message

    def test_the_action_may_have_another_name(self, node, tree, asked):
        tree(node(registry()["CancelControl"], server_name="/wall_e/wait"), **asked).tick()

        assert ["wall_e/wait"] == asked["client"].requests


NO_OPS = {
    "ClearCostmapAroundPose": {"pose": "1;2", "reset_distance": "2.0"},
    "ClearCostmapAroundRobot": {"reset_distance": "2.0"},
    "ClearCostmapExceptRegion": {"reset_distance": "2.0"},
    "ClearEntireCostmap": {"service_name": "global_costmap/clear_entirely_global_costmap"},
    "ReinitializeGlobalLocalization": {"service_name": "reinitialize_global_localization", "server_timeout": "10"},
    "ToggleCollisionMonitor": {"enable": "false"},
}


@pytest.mark.parametrize("tag", NO_OPS)
def test_what_there_is_nothing_to_do_for_succeeds_at_once(node, tree, tag):
    assert "S" == tree(node(registry()[tag], **NO_OPS[tag])).tick()


@pytest.mark.parametrize(
    ("tag", "what"),
    [
        ("ControllerSelector", "controller"),
        ("GoalCheckerSelector", "goal_checker"),
        ("PathHandlerSelector", "path_handler"),
        ("PlannerSelector", "planner"),
        ("ProgressCheckerSelector", "progress_checker"),
        ("SmootherSelector", "smoother"),
    ],
)
class TestSelectors:
    """The selection of a planner, a controller and so on, without a message on the topic."""

    def test_the_default_is_selected(self, node, tree, board, tag, what):
        ports = {f"default_{what}": "Usual", f"selected_{what}": "{chosen}", "topic_name": "choose"}

        assert "S" == tree(node(registry()[tag], **ports)).tick()
        assert "Usual" == board["/chosen"]

    def test_without_a_default_it_fails(self, node, tree, tag, what):
        """Nav2's then wants a choice from its topic, and there is none."""
        ticked = tree(node(registry()[tag]))

        assert "F" == ticked.tick()
        assert f"there is no default_{what} and no selection topic" == ticked.root.feedback_message
