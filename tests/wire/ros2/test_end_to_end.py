"""ROS 2 clients of all distributions drive simulated robots, alone, together and beside JSON clients."""

from __future__ import annotations

import contextlib
import json
from types import SimpleNamespace

import pytest

from hmrsim.actions import registry
from hmrsim.cli.replay import TraceFile
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.geometry_msgs import PoseWithCovarianceStamped
from hmrsim.interfaces.nav2_msgs import NavigateToPose, Wait
from hmrsim.interfaces.nav_msgs import Odometry
from hmrsim.interfaces.rosgraph_msgs import Clock
from hmrsim.protocol.goal import GoalStatus
from hmrsim.services import registry as services
from hmrsim.settings.run import RunSettings
from hmrsim.world import World
from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.hosting.host import Host
from hmrsim_zenoh.ros2.codec.types import message_type, service_type
from hmrsim_zenoh.ros2.wires import RmwZenoh
from hmrsim_zenoh.wire.keys import Verb
from hmrsim_zenoh.wire.session import SessionOptions
from tests.patience import PATIENCE
from tests.simulation import SMALL_WORLD
from tests.wire.ros2.client import (
    ABORTED,
    EXECUTING,
    SUCCEEDED,
    RosClient,
    Unanswered,
    get_state,
    goal_to,
)

FEEDBACK_HASHES = {
    "jazzy": "RIHS01_9d1f6fa2eb975ce733b419ac2e97b134d8ff92b6478b6559feed9a50bdfd82b3",
    "kilted": "RIHS01_9d1f6fa2eb975ce733b419ac2e97b134d8ff92b6478b6559feed9a50bdfd82b3",
    "lyrical": "RIHS01_2c1b4ec1a0e3a53c9aa326aabe717670eeef0ff3d4c3351ff940613b2011728a",
}
DRIVE_TYPE, WAIT_TYPE = (f"nav2_msgs::action::dds_::{name}_SendGoal_" for name in ("NavigateToPose", "Wait"))
LONG = {"time": {"sec": 100_000, "nanosec": 0}}


# --- distributions -----------------------------------------------------------------------------------------------


def test_three_distributions_each_drive_a_robot_of_one_simulator(fast, ros):
    robots = {"jazzy": "wall_e", "kilted": "eve", "lyrical": "cart"}
    drives = [ros(fast, distro).action(f"/{robot}/navigate_to_pose").wait() for distro, robot in robots.items()]
    goals = [drive.send(goal_to(5, 2)) for drive in drives]

    assert [SUCCEEDED] * 3 == [goal.result()[0] for goal in goals]


def test_feedback_of_a_goal_is_published_in_each_layout(fast, ros):
    drives = {distro: ros(fast, distro).action("/wall_e/navigate_to_pose").wait() for distro in FEEDBACK_HASHES}
    goal = drives["jazzy"].send(goal_to(5, 2))
    last = {distro: drive.wait_for_last_feedback(goal.id) for distro, drive in drives.items()}

    assert dict.fromkeys(drives, 0.0) == {distro: one["distance_remaining"] for distro, one in last.items()}
    assert FEEDBACK_HASHES == {
        distro: drive.feedback.items[-1].key.rpartition("/")[2] for distro, drive in drives.items()
    }


def test_a_new_layout_has_all_feedback_of_a_short_goal(live, ros):
    """Another distribution has a subscriber already."""
    name, here, type_ = "/wall_e/navigate_to_pose", goal_to(1, 2), "nav2_msgs::action::dds_::NavigateToPose"
    other = ros(live).action(name).wait()
    assert other.wait_for_feedback(other.send(here).id)
    node = ros(live, "lyrical")
    node.graph.wait_for(("MP", f"{name}/_action/feedback", f"{type_}_FeedbackMessage_"))
    drive = node.action(name)

    assert drive.wait_for_feedback(drive.send(here).id)


@pytest.mark.parametrize("distro", FEEDBACK_HASHES)
def test_goals_with_a_layout_for_each_distribution_succeed(fast, ros, distro):
    drive = ros(fast, distro).action("/wall_e/navigate_through_poses").wait()
    poses = [goal_to(x, 2)["pose"] for x in (5, 9)]
    goal = drive.send({"poses": {"goals": poses}})
    status, result = goal.result()

    assert (SUCCEEDED, 0) == (status, result["error_code"])
    assert 0 == drive.wait_for_last_feedback(goal.id)["number_of_recoveries"]


@pytest.mark.parametrize("distro", FEEDBACK_HASHES)
def test_a_route_is_computed_and_its_path_smoothed(fast, ros, distro):
    node = ros(fast, distro)
    status, found = node.action("/wall_e/compute_route").wait().do({"start_id": 0, "goal_id": 2})
    smoothed = node.action("/wall_e/smooth_path").wait().do({"path": found["path"]})

    assert (SUCCEEDED, [0, 1, 2]) == (status, [one["nodeid"] for one in found["route"]["nodes"]])
    assert [5, 7] == [one["edgeid"] for one in found["route"]["edges"]]
    assert (SUCCEEDED, 3) == (smoothed[0], len(smoothed[1]["path"]["poses"]))


@pytest.mark.parametrize("distro", FEEDBACK_HASHES)
def test_a_route_is_tracked_while_another_goal_drives(fast, ros, distro):
    """The last feedback has no next waypoint."""
    node = ros(fast, distro)
    tracking = node.action("/wall_e/compute_and_track_route").wait()
    goal = tracking.send({"start_id": 1, "goal_id": 2})
    node.action("/wall_e/navigate_to_pose").wait().send(goal_to(9, 2))
    assert SUCCEEDED == goal.result()[0]
    last = tracking.wait_for_last_feedback(goal.id, "next_node_id")

    assert (2, 0, 0, 2) == (
        last["last_node_id"],
        last["next_node_id"],
        last["current_edge_id"],
        len(last["route"]["nodes"]),
    )


def test_a_goal_of_an_unserved_distribution_is_rejected(serve, ros):
    """Without an answer the client would wait forever."""
    options = serve(wires=(RmwZenoh(distros=("jazzy",)),))
    drive = ros(options, "lyrical").action("/wall_e/navigate_through_poses").wait()
    understood = ros(options, "jazzy").action("/wall_e/navigate_through_poses").wait()
    goal = {"poses": {"goals": [goal_to(5, 2)["pose"]]}}

    assert (False, True) == (drive.send(goal).accepted, understood.send(goal).accepted)


def test_goals_that_can_not_be_executed_are_aborted(fast, ros):
    """As with Nav2's servers, a failed transform or an unknown plugin aborts the goal with its code."""
    node = ros(fast)
    elsewhere = goal_to(5, 2) | {"pose": {"header": {"frame_id": "odom"}}}
    status, result = node.action("/wall_e/navigate_to_pose").wait().do(elsewhere)
    plan_status, plan = node.action("/wall_e/compute_path_to_pose").wait().do({"planner_id": "Smac"})

    assert [(ABORTED, 9002), (ABORTED, 201)] == [(status, result["error_code"]), (plan_status, plan["error_code"])]
    assert "unknown frame_id 'odom'" in result["error_msg"]


@pytest.mark.parametrize("distro", FEEDBACK_HASHES)
def test_only_lyrical_rejects_an_empty_path(fast, ros, distro):
    """Earlier controller servers abort the goal."""
    follow = ros(fast, distro).action("/wall_e/follow_path").wait()
    goal = follow.send({"path": {"poses": []}})

    assert (distro != "lyrical") == goal.accepted
    if goal.accepted:
        status, result = goal.result()
        assert (ABORTED, 103) == (status, result["error_code"])


def test_lyrical_s_verdict_where_it_is_served_alone(serve, ros):
    """A goal type that distributions share shows its sender only where a single distribution is served."""
    node = ros(serve(wires=(RmwZenoh(distros=("lyrical",)),)), "lyrical")
    elsewhere = goal_to(5, 2) | {"pose": {"header": {"frame_id": "odom"}}}

    assert not node.action("/wall_e/navigate_to_pose").wait().send(elsewhere).accepted


def test_another_domain_has_its_own_keys(serve, ros):
    options = serve(wires=(RmwZenoh(domain=42),), real_time_factor=0)
    status, _ = ros(options, domain=42).action("/wall_e/wait").wait().do({})
    elsewhere = ros(options)

    assert SUCCEEDED == status
    with pytest.raises(Unanswered):
        elsewhere.service("/wall_e/amcl/get_state", get_state()).call(b"\0\1\0\0\0")


def test_the_world_has_a_clock_poses_and_a_list_of_entities(live, ros):
    node = ros(live)
    clock = node.subscribe("/clock", message_type(Clock, "jazzy"))
    odom = node.subscribe("/eve/odom", message_type(Odometry, "jazzy"))
    found = services()["get_entities"]
    entities = node.service("/get_entities", service_type(found.ros, "jazzy"))

    earlier, later = (one["clock"] for one in clock.wait(lambda messages: len(messages) > 1)[:2])

    assert (earlier["sec"], earlier["nanosec"]) < (later["sec"], later["nanosec"])
    assert 9.0 == odom.next()["pose"]["pose"]["position"]["x"]
    assert {"wall_e", "eve", "cart"} <= set(entities.wait().call(found.request().model_dump())["entities"])


def test_servers_of_a_large_fleet_are_declared_when_looked_for(monkeypatch, serve, ros):
    """Only a node of each robot is declared beforehand."""
    monkeypatch.setattr("hmrsim_zenoh.ros2.publishing.parts.MAX_STANDING", 0)
    options = serve(wires=(RmwZenoh(),), real_time_factor=0)
    watcher, node = ros(options, node="watcher"), ros(options)
    watcher.graph.wait(lambda tokens: any(token.endswith("/%cart/bt_navigator") for token in tokens))
    unasked = watcher.graph.count("SS", "/wall_e/wait/_action/send_goal", WAIT_TYPE)
    unasked += watcher.graph.count("SS", "/cart/navigate_to_pose/_action/send_goal", DRIVE_TYPE)
    wait = node.action("/wall_e/wait").wait()
    goal = wait.send({})
    pose = node.subscribe("/eve/amcl_pose", message_type(PoseWithCovarianceStamped, "jazzy"), latched=True)
    state = node.service("/eve/amcl/get_state", get_state()).wait()

    assert 0 == unasked
    assert SUCCEEDED == goal.result()[0]
    wait.wait_for_status(goal.id, SUCCEEDED)
    assert 9.0 == pose.next()["pose"]["pose"]["position"]["x"]
    assert "active" == state.call(b"\0\1\0\0\0")["current_state"]["label"]


# --- beside JSON -------------------------------------------------------------------------------------------------


def test_a_goal_of_json_preempts_one_of_ros(serve, ros):
    options = serve(clock="lockstep", participants=("nobody",))
    drive = ros(options).action("/wall_e/navigate_to_pose").wait()
    older = drive.send(goal_to(9, 2))
    with Client(options, clock="realtime") as client:
        key = client.keys.action("wall_e", "navigate_to_pose", Verb.SEND_GOAL)
        newer = json.loads(client.get(key, payload=b'{"goal": {"pose": {"pose": {"position": {"x": 5, "y": 2}}}}}'))
    status, result = older.result()

    assert newer["accepted"]
    assert (ABORTED, NavigateToPose.Result.UNKNOWN) == (status, result["error_code"])
    drive.wait_for_status(bytes.fromhex(newer["goal_id"]), EXECUTING)


def test_a_goal_of_ros_preempts_one_of_json(live, ros):
    with Client(live) as client:
        older = client.action_client("wall_e", registry()["wait"]).send_goal(Wait.Goal(time=Duration(sec=100_000)))
        older.wait_accepted(PATIENCE)
        newer = ros(live).action("/wall_e/navigate_to_pose").wait().send(goal_to(1, 2))
        older.result(PATIENCE)

        assert newer.accepted
        assert GoalStatus.ABORTED == older.status


# --- commands and time -------------------------------------------------------------------------------------------


GOALS = {"wall_e": ("door", 5.0, 2.0), "eve": ("home", 1.0, 2.0), "cart": ("shelf", 9.0, 2.0)}


@contextlib.contextmanager
def hosting(path=None, **settings):
    """Return a host of the small world that has not started, traced to a file if one is given."""
    loaded = SimpleNamespace(world=World.model_validate(SMALL_WORLD), hash="", warnings=(), path=None)
    options = SessionOptions(listen=("tcp/127.0.0.1:0",))
    chosen = RunSettings(**settings)
    trace = TraceFile(path, loaded.world, chosen)
    with Host(loaded, options, chosen, wires=(RmwZenoh(),), sinks=trace.sinks) as host, trace.opened(host.simulator):
        yield host


def run_in_lockstep(path, send):
    """Serve the small world in lockstep, send goals while time is stopped, run it, and return the trace."""
    with hosting(path, clock="lockstep", participants=("nurse",), seed=7) as host:
        host.start()
        there = SessionOptions(connect=host.endpoints)
        send(there)
        with Client(there, name="nurse", clock="lockstep") as nurse:
            nurse.sleep(60.0)
        host.stop()
    return path.read_text()


def send_by_ros(options):
    """Send one goal to each robot, each from another distribution."""
    for distro, (robot, (_, x, y)) in zip(FEEDBACK_HASHES, GOALS.items(), strict=True):
        with RosClient(options.connect[0], distro) as ros:
            drive = ros.action(f"/{robot}/navigate_to_pose").wait()
            assert drive.send(goal_to(x, y), goal_id=robot.encode().ljust(16)).accepted


def send_by_json(options):
    with Client(options, clock="realtime") as client:
        for robot, (_, x, y) in GOALS.items():
            goal = NavigateToPose.Goal.model_validate_json(json.dumps(goal_to(x, y)))
            drive = client.action_client(robot, registry()["navigate_to_pose"])
            drive.send_goal(goal, goal_id=robot.encode().ljust(16).hex()).wait_accepted(PATIENCE)


def test_equal_commands_at_stopped_time_give_equal_traces(tmp_path):
    """The wire does not matter."""
    first, second = (run_in_lockstep(tmp_path / name, send_by_ros) for name in ("first", "second"))
    third = run_in_lockstep(tmp_path / "third", send_by_json)

    assert 3 == first.count('"status":4')
    assert first == second
    assert first == third
