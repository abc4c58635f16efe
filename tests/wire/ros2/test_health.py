"""The log of the nodes and the diagnostics of the robots, as ROS's tools show them."""

from __future__ import annotations

from typing import Any

from hmrsim.interfaces.diagnostic_msgs import DiagnosticStatus
from hmrsim.interfaces.rcl_interfaces import Log
from hmrsim_zenoh.ros2.codec.types import message_type
from hmrsim_zenoh.ros2.publishing.endpoints import TOPICS
from tests.wire.ros2.client import goal_to

BATTERY = {"battery": {"capacity": 100.0, "drain": {"default": 0.0}}}
WORLD = {
    "waypoints": {"home": [0, 0], "shelf": [10, 0]},
    "lanes": [["home", "shelf"]],
    "robot_types": {"electric": {"components": BATTERY}},
    "robots": {"eve": {"type": "electric", "at": "home"}, "wall_e": {"at": "shelf"}},
    "faults": [{"type": "breakdown", "robot": "wall_e", "at": 0.0}],
}


def lines(messages: list[dict[str, Any]]) -> list[tuple[str, int, str]]:
    """Return logger, level and text of the lines of a log."""
    return [(one["name"], one["level"], one["msg"]) for one in messages]


def heard(node, topic):
    """Subscribe to a topic of the world; return once the simulator publishes on it."""
    return node.subscribe(f"/{topic}", message_type(TOPICS[topic].message))


def test_the_log_has_the_reasons_of_nodes(live, ros):
    """An aborted goal and a request that is rejected have their nodes' names as loggers."""
    node = ros(live)
    log = heard(node, "rosout")
    client = node.action("/wall_e/navigate_to_pose").wait()
    # A goal to the island, where no lane leads.
    while not log.messages:
        client.do(goal_to(15.0, 2.0))
    client.send(goal_to(1.0, 2.0), bytes(16))

    def complete(messages):
        loggers = {(name, level) for name, level, _ in lines(messages)}
        return {("wall_e.bt_navigator", Log.ERROR), ("wall_e.bt_navigator", Log.WARN)} <= loggers

    texts = [text for _, _, text in lines(log.wait(complete))]
    assert any(text.startswith("navigate_to_pose ABORTED: ") for text in texts)
    assert any("the goal id is zero" in text for text in texts)


def test_diagnostics_are_of_robots_batteries_and_faults(serve, ros):
    node = ros(serve(world=WORLD, real_time_factor=1.0))
    statuses = heard(node, "diagnostics").next()["status"]
    found = {one["name"]: (one["level"], one["hardware_id"]) for one in statuses}

    assert (DiagnosticStatus.OK, "eve") == found["eve: robot"]
    assert (DiagnosticStatus.OK, "eve") == found["eve: battery"]
    assert (DiagnosticStatus.ERROR, "wall_e") == found["wall_e: robot"]
    assert [DiagnosticStatus.WARN] == [level for name, (level, _) in found.items() if ": fault " in name]
