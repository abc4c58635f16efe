"""The topics that RViz and Foxglove show of a simulation, and the effects of RViz's buttons."""

from __future__ import annotations

import logging
import logging.handlers
import math
import queue
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree as ET

import pytest

from hmrsim.interfaces.geometry_msgs import Twist, TwistStamped
from hmrsim.interfaces.nav_msgs import GetMap
from hmrsim.interfaces.simulation_interfaces import DeleteEntity
from hmrsim_zenoh.ros2.codec.types import message_type, service_type
from hmrsim_zenoh.ros2.publishing.endpoints import TOPICS
from tests.patience import PATIENCE
from tests.wire.ros2.client import goal_to

if TYPE_CHECKING:
    from tests.wire.ros2.client import Inbox, RosClient


def listen(node: RosClient, name: str, topic: str) -> Inbox:
    """Subscribe to a topic of the simulator."""
    kind = TOPICS[topic]
    return node.subscribe(name, message_type(kind.message), latched=kind.qos.startswith(":1:"))


def publish(node: RosClient, name: str, topic: str, values: dict[str, Any]) -> None:
    """Publish one message as RViz does, once the simulator's subscriber is known."""
    type_ = message_type(TOPICS[topic].message)
    node.graph.wait_for(("MS", name, type_.dds_name))
    gid = node.declare("MP", name, type_.dds_name, type_.hash)
    key = node.key(name, type_.dds_name, type_.hash)
    node.session.put(key, type_.encode(values), attachment=bytes(16) + bytes((16,)) + gid)


def test_the_map_shows_walls_to_each_subscriber(live, ros):
    node = ros(live)
    first = listen(node, "/map", "map").next()

    info, cells = first["info"], first["data"]
    assert (0.05, 400, 200) == (pytest.approx(info["resolution"]), info["width"], info["height"])
    # The wall at x = 12 m, the inside of the solid, and free space beside it.
    assert (100, 100, 0) == (cells[100 * 400 + 240], cells[100 * 400 + 140], cells[60 * 400 + 140])
    assert first == listen(ros(live, node="late"), "/map", "map").next()
    assert first == listen(node, "/eve/map", "map").next()


def test_the_map_server_answers_with_the_map(fast, ros):
    type_ = service_type(GetMap)
    answer = ros(fast).service("/map_server/map", type_).wait().call({})

    assert "map" == answer["map"]["header"]["frame_id"]
    assert 400 * 200 == len(answer["map"]["data"])


def test_all_frames_are_connected(live, ros):
    """The fixed frames hang on those of ``/tf``, with the robot's name, and on those of the robot's own topic."""
    node = ros(live)
    of_all = listen(node, "/tf_static", "tf_static").next()
    of_one = listen(node, "/eve/tf_static", "tf_static").next()

    def frames(message):
        return {(one["header"]["frame_id"], one["child_frame_id"]) for one in message["transforms"]}

    assert {("map", "eve/odom"), ("eve/base_link", "eve/base_scan")} < frames(of_all)
    assert {("map", "odom"), ("base_link", "base_scan"), ("base_link", "eve/base_link")} < frames(of_one)


def test_the_model_is_urdf_in_the_frames_of_the_robot(live, ros):
    text = listen(ros(live), "/eve/robot_description", "robot_description").next()["data"]
    robot = ET.fromstring(text)

    assert "eve" == robot.get("name")
    assert {"base_link", "base_scan"} == {link.get("name") for link in robot.iter("link")}
    assert ["base_link"] == [parent.get("link") for parent in robot.iter("parent")]


def test_a_plan_leads_from_the_robot_to_its_goal(live, ros):
    node = ros(live)
    plans = listen(node, "/wall_e/plan", "plan")
    client = node.action("/wall_e/navigate_to_pose").wait()
    sent = client.send(goal_to(9.0, 2.0))
    plans.wait(lambda messages: any(len(one["poses"]) > 1 for one in messages))
    poses = next(one["poses"] for one in plans.messages if len(one["poses"]) > 1)

    assert sent.accepted
    assert [(5.0, 2.0), (9.0, 2.0)] == [
        (one["pose"]["position"]["x"], one["pose"]["position"]["y"]) for one in poses[1:]
    ]
    assert 1.0 <= poses[0]["pose"]["position"]["x"] < 5.0
    # The plan shrinks to a point when the robot has stopped.
    sent.cancel()
    plans.wait(lambda messages: len(messages[-1]["poses"]) == 1)


def test_a_footprint_is_where_the_robot_is(serve, ros):
    options = serve(
        world={
            "waypoints": {"a": [3, 4]},
            "robot_types": {"round": {"base": {"radius": 0.5}}},
            "robots": {"r": {"type": "round", "at": "a"}},
        },
        real_time_factor=1.0,
    )
    topic = "local_costmap/published_footprint"
    corners = listen(ros(options), f"/r/{topic}", topic).next()["polygon"]["points"]

    assert 16 == len(corners)
    assert all(pytest.approx(0.25) == (corner["x"] - 3) ** 2 + (corner["y"] - 4) ** 2 for corner in corners)


def test_a_scan_measures_the_walls_around_one_robot(live, ros):
    """Ray 90 of 180 points ahead, to the wall at x = 12 m; behind the robot there is none."""
    node = ros(live)
    scan = listen(node, "/eve/scan", "scan").next()

    assert ("eve/base_scan", 180) == (scan["header"]["frame_id"], len(scan["ranges"]))
    assert pytest.approx(3.0) == scan["ranges"][90]
    assert math.inf == scan["ranges"][0]
    assert pytest.approx(-math.pi) == scan["angle_min"]


def test_markers_follow_items_and_robots(live, ros):
    node = ros(live)
    markers, things = listen(node, "/world/markers", "world/markers"), listen(node, "/world/things", "world/things")

    def labels(message):
        return {one["text"] for one in message["markers"] if one["text"]}

    assert {"wall_e", "eve", "cart"} <= labels(markers.next())
    assert {"parcel", "anvil", "letter"} == labels(things.next())
    delete = node.service("/delete_entity", service_type(DeleteEntity)).wait()
    delete.call({"entity": "letter"})
    things.wait(lambda messages: labels(messages[-1]) == {"parcel", "anvil"})
    delete.call({"entity": "cart"})
    markers.wait(lambda messages: "cart" not in labels(messages[-1]))


def test_rviz_s_goal_button_sends_a_goal(fast, ros):
    node = ros(fast)
    status = node.action("/wall_e/navigate_to_pose").wait().status
    publish(node, "/wall_e/goal_pose", "goal_pose", goal_to(9.0, 2.0)["pose"])

    status.wait(lambda messages: messages and [one["status"] for one in messages[-1]["status_list"]] == [4])


def test_rviz_s_pose_button_moves_the_robot(live, ros):
    node = ros(live)
    poses = listen(node, "/wall_e/amcl_pose", "amcl_pose")
    pose = goal_to(3.0, 2.0)["pose"]
    values = {"header": pose["header"], "pose": {"pose": pose["pose"], "covariance": [0.25] * 36}}
    publish(node, "/wall_e/initialpose", "initialpose", values)

    poses.wait(lambda messages: messages and messages[-1]["pose"]["pose"]["position"]["x"] == 3.0)


@pytest.mark.parametrize("topic", ["goal_pose", "initialpose"])
def test_the_log_has_the_reason_why_a_button_had_no_effect(live, ros, topic):
    pose = goal_to(3.0, 2.0)["pose"] | {"header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": "moon"}}
    values = {"header": pose["header"], "pose": {"pose": pose["pose"], "covariance": [0.0] * 36}}
    lines: queue.Queue[logging.LogRecord] = queue.Queue()
    log, handler = logging.getLogger("hmrsim_zenoh"), logging.handlers.QueueHandler(lines)
    log.addHandler(handler)
    try:
        publish(ros(live), f"/wall_e/{topic}", topic, values if topic == "initialpose" else pose)
        text = lines.get(timeout=PATIENCE).getMessage()
    finally:
        log.removeHandler(handler)

    assert f"ROS 2: /wall_e/{topic}: " in text
    assert "unknown frame_id 'moon'" in text


@pytest.mark.parametrize("stamped", [False, True])
def test_velocities_steer_a_robot(live, ros, stamped):
    """Nav2's velocities are of type Twist up to jazzy, and TwistStamped later."""
    node = ros(live)
    poses = listen(node, "/eve/odom", "odom")
    poses.next()
    zero = {"x": 0.0, "y": 0.0, "z": 0.0}
    twist = {"linear": {**zero, "x": -1.0}, "angular": zero}
    header = {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}
    node.graph.wait_for(("MS", "/eve/cmd_vel", message_type(Twist).dds_name))
    type_ = message_type(TwistStamped if stamped else Twist)
    gid = node.declare("MP", "/eve/cmd_vel", type_.dds_name, type_.hash)
    key = node.key("/eve/cmd_vel", type_.dds_name, type_.hash)
    values = {"header": header, "twist": twist} if stamped else twist
    node.session.put(key, type_.encode(values), attachment=bytes(16) + bytes((16,)) + gid)

    poses.wait(lambda messages: messages[-1]["pose"]["pose"]["position"]["x"] == pytest.approx(8.5))
