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


class TestGoals:
    """The goals of action nodes follow from their ports."""

    def test_navigate_to_pose(self, sent):
        goal = sent(NavigateToPose, goal="1;2", behavior_tree="x.xml")

        assert {"x": 1.0, "y": 2.0} == goal["pose"]["pose"]["position"]
        assert "x.xml" == goal["behavior_tree"]

    def test_navigate_through_poses(self, sent):
        goal = sent(NavigateThroughPoses, goals="1;2|3;4")

        assert [1.0, 3.0] == [pose["pose"]["position"]["x"] for pose in goal["poses"]["goals"]]

    def test_compute_path_to_pose(self, sent):
        goal = sent(ComputePathToPose, goal="1;2", planner_id="GridBased")

        assert ({"x": 1.0, "y": 2.0}, "GridBased") == (goal["goal"]["pose"]["position"], goal["planner_id"])
        assert "use_start" not in goal

    @pytest.mark.parametrize(("use_start", "uses"), [({}, True), ({"use_start": "false"}, False)])
    def test_compute_path_from_a_pose(self, sent, use_start, uses):
        goal = sent(ComputePathToPose, goal="1;2", start="3;4", **use_start)

        assert uses == goal.get("use_start", False)

    def test_follow_path(self, sent, path):
        goal = sent(FollowPath, path=path((0, 0), (1, 0)), controller_id="FollowPath", goal_checker_id="exact")

        assert 2 == len(goal["path"]["poses"])
        assert ("FollowPath", "exact") == (goal["controller_id"], goal["goal_checker_id"])

    def test_compute_path_through_poses(self, sent):
        goal = sent(ComputePathThroughPoses, goals="1;2|3;4", planner_id="GridBased")
        started = sent(ComputePathThroughPoses, goals="1;2", start="5;6")

        assert [1.0, 3.0] == [pose["pose"]["position"]["x"] for pose in goal["goals"]["goals"]]
        assert "use_start" not in goal
        assert (True, {"x": 5.0, "y": 6.0}) == (started["use_start"], started["start"]["pose"]["position"])

    def test_smooth_path(self, sent, path):
        goal = sent(SmoothPath, unsmoothed_path=path((0, 0), (1, 0)), smoother_id="route_smoother")

        assert 2 == len(goal["path"]["poses"])
        assert ("route_smoother", {"sec": 3}) == (goal["smoother_id"], goal["max_smoothing_duration"])

    @pytest.mark.parametrize("kind", [ComputeRoute, ComputeAndTrackRoute])
    def test_routes(self, sent, kind):
        assert {"start_id": 2, "goal_id": 3} == sent(kind, start_id="2", goal_id="3", goal="1;2")
        goal = sent(kind, use_poses="true", goal="1;2", start="3;4", goal_id="3")
        assert ({"goal", "use_poses"}, 1.0) == (goal.keys(), goal["goal"]["pose"]["position"]["x"])
        goal = sent(kind, use_poses="true", use_start="true", goal="1;2", start="3;4")
        assert (True, 3.0) == (goal["use_start"], goal["start"]["pose"]["position"]["x"])

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

    def test_spin(self, sent):
        assert {"target_yaw": 1.57, "time_allowance": {"sec": 10}} == sent(Spin)
        assert {"target_yaw": -3.0, "time_allowance": {"nanosec": 500000000}} == sent(
            Spin, spin_dist="-3", time_allowance="0.5"
        )

    def test_wait(self, sent):
        assert {"time": {"sec": 1}} == sent(Wait)
        assert {"time": {"sec": 5}} == sent(Wait, wait_duration="5.0")
        assert {"time": {"sec": 5}} == sent(Wait, wait_duration="-5")

    @pytest.mark.parametrize(
        ("kind", "distance", "speed"),
        [(BackUp, "backup_dist", "backup_speed"), (DriveOnHeading, "dist_to_travel", "speed")],
    )
    def test_straight_on_and_back(self, sent, kind, distance, speed):
        assert {"target": {"x": 0.15}, "speed": 0.025, "time_allowance": {"sec": 10}} == sent(kind)
        assert {"target": {"x": 0.3}, "speed": 0.2} == sent(
            kind, **{distance: "0.3", speed: "0.2", "time_allowance": "0"}
        )

    def test_dock_robot(self, sent):
        assert {"dock_id": "charger"} == sent(DockRobot, dock_id="charger")
        goal = sent(DockRobot, use_dock_id="false", dock_pose="1;2", dock_type="charger", max_staging_time="30")
        assert (False, "charger", 30.0) == (goal["use_dock_id"], goal["dock_type"], goal["max_staging_time"])
        assert {"x": 1.0, "y": 2.0} == goal["dock_pose"]["pose"]["position"]

    def test_undock_robot(self, sent):
        assert {} == sent(UndockRobot)
        assert {"max_undocking_time": 5.0} == sent(UndockRobot, max_undocking_time="5")

    def test_pickup(self, sent):
        assert {"target_name": "parcel"} == sent(Pickup, target_name="parcel")

    def test_place(self, sent):
        assert {} == sent(Place)
        goal = sent(Place, attached_object_name="parcel", place_pose="1;2")
        assert "parcel" == goal["attached_object_name"]
        assert [{"x": 1.0, "y": 2.0}] == [place["place_pose"]["pose"]["position"] for place in goal["place_locations"]]

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
                """Return it."""
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
        goal._end(GoalStatus.SUCCEEDED, goal.action.result(path=path((0, 0), (1, 0))))

        assert "S" == ticked.tick()
        assert (path((0, 0), (1, 0)), 0, "") == (board["/path"], board["/code"], board["/message"])

    def test_aborted_is_failure_with_the_code(self, computing, board):
        ticked, goal = computing
        goal.abort(208, "no route")

        assert "F" == ticked.tick()
        assert (Path(), 208, "no route") == (board["/path"], board["/code"], board["/message"])

    def test_canceled_is_success(self, computing, board):
        """The client that canceled the goal had a reason: the node succeeds, with an empty path."""
        ticked, goal = computing
        goal.end_canceled()

        assert "S" == ticked.tick()
        assert (Path(), 0) == (board["/path"], board["/code"])

    def test_rejected_is_failure_with_the_code_of_the_answer(self, computing, board):
        """The code 1 is Nav2's GOAL_REJECTED."""
        ticked, goal = computing
        goal.reject("not_ready", "battery empty")

        assert "F" == ticked.tick()
        assert (1, "not_ready: battery empty") == (board["/code"], board["/message"])

    def test_what_was_aborted_in_an_earlier_life_has_a_code_of_its_own(self, computing, board):
        ticked, goal = computing
        goal.expire(GoalStatus.ABORTED)

        assert "F" == ticked.tick()
        assert (Path(), 200) == (board["/path"], board["/code"])

    def test_a_server_that_does_not_answer_is_failure(self, computing, board):
        """The code 2 is Nav2's SEND_GOAL_FAILURE."""
        ticked, goal = computing
        goal.fail(SimulatorNotFound("nobody there"))

        assert "F" == ticked.tick()
        assert (2, "nobody there") == (board["/code"], board["/message"])

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
        goal._end(GoalStatus.SUCCEEDED, goal.action.result(path=path((0, 0), (1, 0))))
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
        client.goals[0]._end(GoalStatus.SUCCEEDED, client.goals[0].action.result(num_retries=2))
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
        goal._end(GoalStatus.SUCCEEDED, goal.action.result(execution_duration=Duration(sec=4)))
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

    def test_one_is_success(self, picking, board):
        """Nav2's code of success would be 0."""
        ticked, goal = picking
        goal._end(GoalStatus.SUCCEEDED, goal.action.failure(1, ""))

        assert "S" == ticked.tick()
        assert 1 == board["/code"]

    def test_a_failure_has_its_code_and_its_message(self, picking, board):
        ticked, goal = picking
        goal.abort(-4, "'anvil' is too heavy")

        assert "F" == ticked.tick()
        assert (-4, "'anvil' is too heavy") == (board["/code"], board["/message"])

    def test_no_simulator_is_failure(self, picking, board):
        """The error code is MoveIt's FAILURE."""
        ticked, goal = picking
        goal.fail(SimulatorNotFound("nobody there"))
        ticked.tick()

        assert 99999 == board["/code"]


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
