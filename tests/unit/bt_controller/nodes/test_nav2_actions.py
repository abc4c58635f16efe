"""Nav2's actions as nodes: the goals that their ports make, and what their ends mean."""

from __future__ import annotations

import math

import pytest
from py_trees.common import Status

from bt_controller.core.node import PortError
from bt_controller.core.robots import NotServed
from bt_controller.nodes.actions.manipulation import DockRobot, Pickup, Place, UndockRobot
from bt_controller.nodes.actions.navigation import (
    BackUp,
    DriveOnHeading,
    NavigateThroughPoses,
    NavigateToPose,
    Spin,
    Wait,
)
from bt_controller.nodes.actions.paths import ComputePathThroughPoses, ComputePathToPose, FollowPath, SmoothPath
from bt_controller.nodes.actions.routes import ComputeAndTrackRoute, ComputeRoute
from bt_controller.nodes.conditions.goals import IsWithinPathTrackingBounds
from bt_controller.nodes.controls.nav2 import PipelineSequence
from bt_controller.nodes.controls.sequences import ReactiveSequence
from hmrsim.actions import registry
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.nav2_msgs import TrackingFeedback
from hmrsim.interfaces.nav_msgs import Path
from hmrsim.protocol.goal import GoalStatus
from hmrsim_zenoh.client.places import pose_at
from hmrsim_zenoh.errors import SimulatorNotFound
from tests.cases import case


@pytest.fixture
def known(client):
    """Return what nodes are set up with, for a robot that has all actions."""
    client.info = lambda: {
        "robots": [{"name": "wall_e", "actions": list(registry())}],
        "aliases": {"a/b": "wall_e/wait"},
    }
    return {"client": client, "robot": "wall_e"}


@pytest.fixture
def sent(node, tree, known, client):
    """Return the function that ticks a node and returns the plain values of its goal that are not the default."""

    def run(kind, **ports):
        tree(node(kind, **ports), **known).tick()
        return client.goals[-1].goal.model_dump(exclude_defaults=True)

    return run


def at(x, y):
    return {"pose": {"position": {"x": x, "y": y}}}


ONE, THREE = at(1.0, 2.0), at(3.0, 4.0)
TEN_SECONDS = {"time_allowance": {"sec": 10}}
BY_POSE = {"use_poses": "true", "goal": "1;2", "start": "3;4"}

GOALS = [
    (NavigateToPose, {"goal": "1;2", "behavior_tree": "x.xml"}, {"pose": ONE, "behavior_tree": "x.xml"}),
    (NavigateThroughPoses, {"goals": "1;2|3;4"}, {"poses": {"goals": [ONE, THREE]}}),
    (ComputePathToPose, {"goal": "1;2", "planner_id": "GridBased"}, {"goal": ONE, "planner_id": "GridBased"}),
    (ComputePathToPose, {"goal": "1;2", "start": "3;4"}, {"goal": ONE, "start": THREE, "use_start": True}),
    (ComputePathToPose, {"goal": "1;2", "start": "3;4", "use_start": "false"}, {"goal": ONE, "start": THREE}),
    (ComputePathThroughPoses, {"goals": "1;2|3;4"}, {"goals": {"goals": [ONE, THREE]}}),
    (
        ComputePathThroughPoses,
        {"goals": "1;2", "start": "3;4", "planner_id": "GridBased"},
        {"goals": {"goals": [ONE]}, "start": THREE, "use_start": True, "planner_id": "GridBased"},
    ),
    (Spin, {}, {"target_yaw": 1.57, **TEN_SECONDS}),
    (
        Spin,
        {"spin_dist": "-3", "time_allowance": "0.5"},
        {"target_yaw": -3.0, "time_allowance": {"nanosec": 500000000}},
    ),
    (Wait, {}, {"time": {"sec": 1}}),
    (Wait, {"wait_duration": "5.0"}, {"time": {"sec": 5}}),
    (Wait, {"wait_duration": "-5"}, {"time": {"sec": 5}}),
    (BackUp, {}, {"target": {"x": 0.15}, "speed": 0.025, **TEN_SECONDS}),
    (
        BackUp,
        {"backup_dist": "0.3", "backup_speed": "0.2", "time_allowance": "0"},
        {"target": {"x": 0.3}, "speed": 0.2},
    ),
    (DriveOnHeading, {}, {"target": {"x": 0.15}, "speed": 0.025, **TEN_SECONDS}),
    (
        DriveOnHeading,
        {"dist_to_travel": "0.3", "speed": "0.2", "time_allowance": "0"},
        {"target": {"x": 0.3}, "speed": 0.2},
    ),
    (DockRobot, {"dock_id": "charger"}, {"dock_id": "charger"}),
    (
        DockRobot,
        {"use_dock_id": "false", "dock_pose": "1;2", "dock_type": "charger", "max_staging_time": "30"},
        {"use_dock_id": False, "dock_pose": ONE, "dock_type": "charger", "max_staging_time": 30.0},
    ),
    (UndockRobot, {}, {}),
    (UndockRobot, {"max_undocking_time": "5"}, {"max_undocking_time": 5.0}),
    (Pickup, {"target_name": "parcel"}, {"target_name": "parcel"}),
    (Place, {}, {}),
    (
        Place,
        {"attached_object_name": "parcel", "place_pose": "1;2"},
        {"attached_object_name": "parcel", "place_locations": [{"place_pose": ONE}]},
    ),
]
for route in (ComputeRoute, ComputeAndTrackRoute):
    GOALS += [
        (route, {"start_id": "2", "goal_id": "3", "goal": "1;2"}, {"start_id": 2, "goal_id": 3}),
        (route, {**BY_POSE, "goal_id": "3"}, {"goal": ONE, "use_poses": True}),
        (route, {**BY_POSE, "use_start": "true"}, {"goal": ONE, "start": THREE, "use_poses": True, "use_start": True}),
    ]


class TestGoals:
    """The goals of action nodes follow from their ports."""

    def test_a_goal_is_made_from_ports(self, sent):
        for kind, ports, goal in GOALS:
            with case(f"{kind.__name__}, {ports}"):
                assert goal == sent(kind, **ports)

    @pytest.mark.parametrize(
        ("kind", "port", "ports"),
        [
            (FollowPath, "path", {"controller_id": "FollowPath", "goal_checker_id": "exact"}),
            (SmoothPath, "unsmoothed_path", {"smoother_id": "route_smoother"}),
        ],
    )
    def test_a_path_and_its_plugins_are_in_the_goal(self, sent, path, kind, port, ports):
        goal = sent(kind, **{port: path((0, 0), (1, 0))}, **ports)

        assert 2 == len(goal["path"]["poses"])
        assert ports == {name: goal[name] for name in ports}

    def test_smoothing_takes_three_seconds_at_most(self, sent, path):
        assert {"sec": 3} == sent(SmoothPath, unsmoothed_path=path((0, 0)))["max_smoothing_duration"]

    @pytest.mark.parametrize(
        ("ports", "text"),
        [
            ({"use_poses": "true"}, "port 'goal' has no value yet"),
            ({"use_poses": "true", "use_start": "true", "goal": "1;2"}, "port 'start' has no value yet"),
            ({"goal_id": 65536}, "port 'goal_id': 65536 is not the id of a waypoint, from 0 to 65535"),
        ],
    )
    def test_a_route_without_ends_is_an_error_that_names_the_port(self, node, tree, known, ports, text):
        with pytest.raises(PortError, match=text):
            tree(node(ComputeRoute, **ports), **known).tick()

    def test_what_ports_lead_to_is_read_when_the_goal_is_sent(self, node, tree, known, client, board):
        ticked = tree(node(NavigateToPose, goal="{goal}"), **known)
        board["/goal"] = pose_at(7.0, 8.0)
        ticked.tick()

        assert 7.0 == client.goals[0].goal.pose.pose.position.x

    def test_a_port_without_a_value_is_an_error_that_names_it(self, node, tree, known):
        with pytest.raises(PortError, match=r"port 'path' has no value yet"):
            tree(node(FollowPath, path="{path}"), **known).tick()


class TestServer:
    """The port server_name selects the action."""

    def test_the_default_server_is_the_usual_name(self, node, tree, known, client):
        tree(node(Wait, server_timeout="20"), **known).tick()

        assert ("wall_e", "wait") == (client.goals[0].robot, client.goals[0].action.name)

    @pytest.mark.parametrize("name", ["wait", "/wall_e/wait", "a/b"])
    def test_another_name_of_the_action(self, node, tree, known, client, name):
        tree(node(Wait, server_name=name), **known).tick()

        assert "wait" == client.goals[0].action.name

    def test_a_name_of_another_action_is_refused(self, node, tree, known):
        with pytest.raises(PortError, match=r"port 'server_name': 'spin' is not a name of 'wait'"):
            tree(node(Wait, server_name="spin"), **known)

    def test_a_goal_that_its_message_refuses_is_an_error_that_names_the_field(self, node, tree, known):
        """A custom node may build such a goal from ports whose values are valid alone."""

        class Tabled(Pickup):
            """Takes an item of a number, where the message wants a name."""

            def goal(self):
                return registry()["pickup"].goal(target_name=7)

        wanted = r"^Tabled1: the goal of 'pickup': target_name: input should be a valid string, got 7$"
        with pytest.raises(PortError, match=wanted):
            tree(node(Tabled), **known).tick()

    def test_a_name_that_is_not_served_is_an_error(self, node, tree, known):
        with pytest.raises(NotServed, match=r"robot 'wall_e' has no action 'wait_server'"):
            tree(node(Wait, server_name="wait_server"), **known)


class TestEnds:
    """The end of a goal sets the status, as in Nav2's BtActionNode."""

    @pytest.fixture
    def computing(self, node, tree, known, client):
        """Return a tree that computes a path, ticked once, and its goal."""
        ports = {"path": "{path}", "error_code_id": "{code}", "error_msg": "{message}"}
        ticked = tree(node(ComputePathToPose, goal="1;2", **ports), **known)
        ticked.tick()
        return ticked, client.goals[0]

    def test_it_runs_until_the_goal_has_ended(self, computing):
        ticked, goal = computing
        goal.accept()

        assert "R" == ticked.tick()
        assert math.inf == ticked.due()

    def test_succeeded_is_success_with_its_result(self, computing, board, path):
        ticked, goal = computing
        goal.end(GoalStatus.SUCCEEDED, goal.action.result(path=path((0, 0), (1, 0))))

        assert "S" == ticked.tick()
        assert (path((0, 0), (1, 0)), 0, "") == (board["/path"], board["/code"], board["/message"])

    @pytest.mark.parametrize(
        ("end", "status", "code", "message"),
        [
            (lambda goal: goal.abort(208, "no route"), "F", 208, "no route"),
            (lambda goal: goal.end_canceled(), "S", 0, ""),
            (lambda goal: goal.reject("not_ready", "battery empty"), "F", 1, "not_ready: battery empty"),
            (lambda goal: goal.fail(SimulatorNotFound("nobody there")), "F", 2, "nobody there"),
        ],
        ids=["aborted", "canceled by a client with a reason", "rejected", "not answered"],
    )
    def test_other_ends_have_a_code_and_no_path(self, computing, board, end, status, code, message):
        """1 is Nav2's GOAL_REJECTED, and 2 its SEND_GOAL_FAILURE."""
        ticked, goal = computing
        end(goal)

        assert status == ticked.tick()
        assert (Path(), code, message) == (board["/path"], board["/code"], board["/message"])

    def test_a_goal_that_can_not_be_sent_is_failure(self, node, tree, known, client, board):
        client.refuses = SimulatorNotFound("nobody there")
        ticked = tree(node(Wait, error_code_id="{code}"), **known)

        assert "F" == ticked.tick()
        assert 2 == board["/code"]

    def test_halted_it_cancels_its_goal(self, computing, board, path):
        ticked, goal = computing
        board["/path"] = path((0, 0), (1, 0))
        ticked.halt()

        assert goal.canceled
        assert Path() == board["/path"]

    def test_a_reset_after_its_end_takes_nothing_away(self, computing, board, path):
        ticked, goal = computing
        goal.end(GoalStatus.SUCCEEDED, goal.action.result(path=path((0, 0), (1, 0))))
        ticked.tick()
        ticked.halt()

        assert path((0, 0), (1, 0)) == board["/path"]

    @pytest.mark.parametrize(("end", "status"), [("succeed", "S"), ("abort", "F")])
    def test_ticked_again_without_a_reset_it_ends_as_it_did(self, computing, client, end, status):
        ticked, goal = computing
        goal.succeed() if end == "succeed" else goal.abort(208, "no route")

        assert status * 2 == ticked.ticks(1, 2)
        assert 1 == len(client.goals)
        assert math.inf == ticked.due()

    def test_ticked_again_after_a_reset_it_sends_its_goal_again(self, computing, client):
        ticked, goal = computing
        goal.succeed()
        ticked.tick()
        ticked.halt()
        ticked.tick()

        assert 2 == len(client.goals)

    def test_a_child_of_a_pipeline_is_not_sent_again_while_the_next_one_runs(self, node, told, tree, known, client):
        ticked = tree(node(PipelineSequence, node(Wait), told("R")), **known)
        ticked.tick()
        client.goals[0].succeed()

        assert "RR" == ticked.ticks(1, 2)
        assert 1 == len(client.goals)

    def test_docking_writes_whether_it_succeeded(self, node, tree, known, client, board):
        ticked = tree(node(DockRobot, success="{done}", num_retries="{retries}"), **known)
        ticked.tick()
        client.goals[0].end(GoalStatus.SUCCEEDED, client.goals[0].action.result(num_retries=2))
        ticked.tick()
        assert (True, 2) == (board["/done"], board["/retries"])
        ticked.halt()
        ticked.tick()
        client.goals[1].abort(904, "no dock")
        ticked.tick()
        assert board["/done"] is False

    def test_undocking_writes_whether_it_succeeded(self, node, tree, known, client, board):
        ticked = tree(node(UndockRobot, success="{done}"), **known)
        ticked.tick()
        client.goals[0].succeed()
        ticked.tick()
        assert board["/done"] is True
        ticked.halt()
        ticked.tick()
        ticked.halt()
        assert board["/done"] is False


class TestFeedback:
    """Feedback is written to output ports while a goal runs."""

    @pytest.fixture
    def following(self, node, tree, known, client, path):
        """Return the function that makes a tree that follows a path, ticked once, and its goal."""

        def make(*readers):
            followed = node(FollowPath, path=path((0, 0), (1, 0)), tracking_feedback="{tracking}")
            ticked = tree(node(ReactiveSequence, *readers, followed), **known)
            ticked.tick()
            client.goals[0].accept()
            return ticked, client.goals[0]

        return make

    def test_it_tells_how_the_robot_keeps_to_its_path(self, node, following, board):
        ticked, goal = following(node(IsWithinPathTrackingBounds, tracking_feedback="{tracking}"))
        goal.feed(tracking_feedback=TrackingFeedback(position_tracking_error=0.25))
        ticked.tick()
        assert 0.25 == board["/tracking"].position_tracking_error
        goal.succeed()
        ticked.tick()
        assert TrackingFeedback() == board["/tracking"]

    def test_it_tells_nothing_that_no_node_reads(self, following, board):
        ticked, goal = following()
        goal.feed(tracking_feedback=TrackingFeedback(position_tracking_error=0.25))
        ticked.tick()

        assert "/tracking" not in board
        assert not ticked.root.children[-1].wants_feedback

    def test_a_path_through_poses_that_is_not_there_reached_none_of_them_last(self, node, tree, known, client, board):
        """The index is lyrical's ALL_GOALS, as after a path to all."""
        ports = {"goals": "1;2|3;4", "path": "{path}", "last_reached_index": "{last}"}
        ticked = tree(node(ComputePathThroughPoses, **ports), **known)
        ticked.tick()
        client.goals[0].abort(308, "no path")

        assert ("F", Path(), -1) == (ticked.tick(), board["/path"], board["/last"])

    def test_a_route_is_tracked(self, node, tree, known, client, board):
        ports = {"last_node_id": "{last}", "path": "{path}", "execution_duration": "{seconds}"}
        ticked = tree(node(ComputeAndTrackRoute, goal_id="3", **ports), **known)
        ticked.tick()
        goal = client.goals[0]
        goal.accept()
        goal.feed(last_node_id=7)
        assert ("R", 7, Path()) == (ticked.tick(), board["/last"], board["/path"])
        goal.end(GoalStatus.SUCCEEDED, goal.action.result(execution_duration=Duration(sec=4)))
        assert ("S", 0, 4) == (ticked.tick(), board["/last"], board["/seconds"].sec)

    def test_another_route_replaces_it(self, node, tree, known, client, board):
        board["/to"] = 3
        ticked = tree(node(ComputeAndTrackRoute, goal_id="{to}"), **known)
        ticked.tick()
        board["/to"] = 4
        ticked.tick()

        assert [3, 4] == [goal.goal.goal_id for goal in client.goals]


class TestMoveIt:
    """Nodes of MoveIt's actions have MoveIt's codes."""

    @pytest.fixture
    def picking(self, node, tree, known, client):
        """Return a tree that picks something up, ticked once, and its goal."""
        ticked = tree(node(Pickup, target_name="anvil", error_code_id="{code}", error_msg="{message}"), **known)
        ticked.tick()
        return ticked, client.goals[0]

    @pytest.mark.parametrize(
        ("end", "status", "code", "message"),
        [
            (lambda goal: goal.end(GoalStatus.SUCCEEDED, goal.action.failure(1, "")), "S", 1, ""),
            (lambda goal: goal.abort(-4, "'anvil' is too heavy"), "F", -4, "'anvil' is too heavy"),
            (lambda goal: goal.fail(SimulatorNotFound("nobody there")), "F", 99999, "nobody there"),
        ],
        ids=["SUCCESS", "CONTROL_FAILED", "FAILURE without a simulator"],
    )
    def test_an_end_has_its_code_and_its_message(self, picking, board, end, status, code, message):
        ticked, goal = picking
        end(goal)

        assert status == ticked.tick()
        assert (code, message) == (board["/code"], board["/message"])


class TestFollowPath:
    """Another path while it drives."""

    @pytest.fixture
    def following(self, node, tree, known, client, board, path):
        """Return a tree that follows a path that the robot has accepted."""
        board["/path"] = path((0, 0), (4, 0))
        ticked = tree(node(FollowPath, path="{path}", controller_id="{controller}", error_code_id="{code}"), **known)
        board["/controller"] = "FollowPath"
        ticked.tick()
        client.goals[0].accept()
        return ticked

    def test_the_same_path_is_not_sent_twice(self, following, client):
        assert "RR" == following.ticks(1, 2)
        assert 1 == len(client.goals)

    def test_another_path_replaces_the_goal(self, following, client, board, path):
        board["/path"] = path((1, 0), (4, 1))

        assert "R" == following.tick()
        assert path((1, 0), (4, 1)) == client.goals[1].goal.path
        assert not client.goals[0].canceled

    def test_the_end_of_the_goal_that_was_replaced_is_of_no_matter(self, following, client, board, path):
        board["/path"] = path((1, 0), (4, 1))
        following.tick()
        client.goals[0].abort(100, "preempted")

        assert "R" == following.tick()
        assert "/code" not in board
        client.goals[1].succeed()
        assert "S" == following.tick()

    def test_another_controller_replaces_the_goal(self, following, client, board):
        board["/controller"] = "Other"
        following.tick()

        assert "Other" == client.goals[1].goal.controller_id

    def test_where_the_new_goal_can_not_be_sent_the_old_one_is_canceled(self, following, client, board, path):
        board["/path"] = path((1, 0), (4, 1))
        client.refuses = SimulatorNotFound("nobody there")

        assert "F" == following.tick()
        assert client.goals[0].canceled

    def test_a_path_without_poses_does_not(self, following, client, board):
        board["/path"] = Path()

        assert "R" == following.tick()
        assert 1 == len(client.goals)

    def test_it_is_not_looked_at_for_another_path(self, following):
        """A planner writes a new path during a tick."""
        assert math.inf == following.due()

    def test_halted_it_cancels_all_that_is_under_way(self, following, client, board, path):
        board["/path"] = path((1, 0), (4, 1))
        following.tick()
        following.halt()

        assert [True, True] == [goal.canceled for goal in client.goals]
        assert Status.INVALID is following.root.status
