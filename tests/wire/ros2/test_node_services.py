"""Services of nodes as called by ``ros2 param``, ``ros2 lifecycle`` and a lifecycle manager."""

from __future__ import annotations

import hashlib
import json
from concurrent.futures import ThreadPoolExecutor

import pytest

from hmrsim.actions import registry
from hmrsim.interfaces.lifecycle_msgs import Transition
from hmrsim.interfaces.nav2_msgs import ManageLifecycleNodes
from hmrsim.interfaces.nav_msgs import OccupancyGrid
from hmrsim.interfaces.rcl_interfaces import ParameterValue
from hmrsim.interfaces.rosgraph_msgs import Clock
from hmrsim.interfaces.sensor_msgs import BatteryState
from hmrsim.trace.replay import replay
from hmrsim_zenoh.ros2.codec.types import message_type, service_type
from hmrsim_zenoh.ros2.names import NODE_SERVICES, nodes_of, own_services
from tests.patience import PATIENCE
from tests.wire.ros2.client import ABORTED, SUCCEEDED, RosClient, ros_action
from tests.wire.ros2.test_end_to_end import LONG, hosting

DEACTIVATE, ACTIVATE = Transition.TRANSITION_DEACTIVATE, Transition.TRANSITION_ACTIVATE
MANAGE = ManageLifecycleNodes.Request
STARTUP, PAUSE, RESUME, RESET, SHUTDOWN = MANAGE.STARTUP, MANAGE.PAUSE, MANAGE.RESUME, MANAGE.RESET, MANAGE.SHUTDOWN
ACTIONS = tuple(registry())
CLOCK, MAP, BATTERY = (message_type(kind).hash for kind in (Clock, OccupancyGrid, BatteryState))
NODES = [
    *("amcl", "bt_navigator", "planner_server", "controller_server", "behavior_server", "waypoint_follower"),
    *("docking_server", "route_server", "smoother_server", "move_group", "base_driver"),
]


class Tool:
    """A ROS node that calls the services of another node once their servers are visible."""

    def __init__(self, client, node):
        self._client, self._node = client, node
        self._services = {}

    def call(self, service, **fields):
        kind = NODE_SERVICES[service]
        if service not in self._services:
            name = f"{self._node}/{service}"
            self._services[service] = self._client.service(name, service_type(kind, self._client.distro)).wait()
        return self._services[service].call(self._services[service].type.request.encode(kind.Request(**fields)))

    def change(self, number=0, label=""):
        """Request a transition; return whether the state has changed."""
        return self.call("change_state", transition=Transition(id=number, label=label))["success"]

    def state(self):
        return self.call("get_state")["current_state"]["label"]


@pytest.fixture
def tool(fast, ros):
    """Return the function that creates tools for a node."""
    return lambda node, **options: Tool(ros(fast, **options), node)


# --- parameters --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("node", [*(f"/wall_e/{name}" for name in NODES), "/hmrsim", "/map_server"])
def test_all_nodes_have_parameters(tool, node):
    """``ros2 param list`` waits for six services of each node, and requests the types of the listed names."""
    tool = tool(node)
    names = tool.call("list_parameters")["result"]["names"]
    descriptors = tool.call("describe_parameters", names=names)["descriptors"]
    types = tool.call("get_parameter_types", names=names)["types"]
    values = tool.call("get_parameters", names=names)["values"]

    assert "use_sim_time" in names == sorted(names)
    assert names == [one["name"] for one in descriptors]
    assert {True} == {one["read_only"] for one in descriptors}
    assert list(types) == [one["type"] for one in descriptors] == [one["type"] for one in values]


@pytest.mark.parametrize("distro", ["jazzy", "kilted", "lyrical"])
def test_parameters_have_the_names_of_nav2_and_the_values_of_the_robot(tool, distro):
    tool = tool("/wall_e/controller_server", distro=distro)
    speed, ids = tool.call("get_parameters", names=["FollowPath.max_vel_x", "controller_plugins"])["values"]

    assert (ParameterValue.DOUBLE, 1.0) == (speed["type"], speed["double_value"])
    assert (ParameterValue.STRING_ARRAY, ["FollowPath"]) == (ids["type"], ids["string_array_value"])


def test_setting_a_parameter_fails_with_a_reason(tool):
    tool = tool("/wall_e/controller_server")
    new = [{"name": name, "value": {"type": 3, "double_value": 2.0}} for name in ("FollowPath.max_vel_x", "nothing")]
    each = tool.call("set_parameters", parameters=new)["results"]
    all_ = tool.call("set_parameters_atomically", parameters=new)["result"]

    assert [False, False, False] == [one["successful"] for one in (*each, all_)]
    assert (
        "parameter 'FollowPath.max_vel_x' is read-only: it comes from the world's file or the simulator's options"
        == each[0]["reason"]
    )
    assert "parameter 'nothing' does not exist" == each[1]["reason"]
    (value,) = tool.call("get_parameters", names=["FollowPath.max_vel_x"])["values"]
    assert 1.0 == value["double_value"]


def test_unknown_parameters_have_no_values(tool):
    """Like rclcpp, the reply is empty if one of the names is unknown."""
    tool = tool("/wall_e/amcl")
    names = ["use_sim_time", "nothing"]

    assert [] == tool.call("get_parameters", names=names)["values"]
    assert [] == list(tool.call("get_parameter_types", names=names)["types"])
    assert [] == tool.call("describe_parameters", names=names)["descriptors"]


def test_parameters_are_listed_by_prefix_and_depth(tool):
    """The depth counts the parts of a name after the prefix."""
    tool = tool("/wall_e/controller_server")
    of_plugin = tool.call("list_parameters", prefixes=["FollowPath"])["result"]
    top = tool.call("list_parameters", depth=1)["result"]

    assert {"FollowPath"} == {name.partition(".")[0] for name in of_plugin["names"]}
    assert ["FollowPath"] == of_plugin["prefixes"]
    assert ["controller_plugins", "odom_topic", "start_type_description_service", "use_sim_time"] == top["names"]
    assert [] == tool.call("list_parameters", prefixes=["Follow"])["result"]["names"]


# --- types -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("distro", ["jazzy", "lyrical"])
def test_a_node_describes_the_types_of_its_endpoints(tool, distro):
    """A tool that has not installed a type finds its hash in the graph, and checks the description against it."""
    tool, action = tool("/wall_e/bt_navigator", distro=distro), ros_action("navigate_to_pose", distro)
    for type_ in (action.feedback, action.status, action.get_result, service_type(NODE_SERVICES["get_state"], distro)):
        reply = tool.call("get_type_description", type_name=type_.name, type_hash=type_.hash)
        described = reply["type_description"]
        for one in (described["type_description"], *described["referenced_type_descriptions"]):
            assert {""} == {field.pop("default_value") for field in one["fields"]}

        assert (True, type_.name) == (reply["successful"], described["type_description"]["type_name"])
        assert type_.hash == f"RIHS01_{hashlib.sha256(json.dumps(described).encode()).hexdigest()}"


def test_a_node_does_not_describe_the_types_of_others(tool):
    type_ = ros_action("dock_robot").feedback
    reply = tool("/wall_e/bt_navigator").call("get_type_description", type_name=type_.name, type_hash=type_.hash)

    assert (False, "Type not currently in use by this node") == (reply["successful"], reply["failure_reason"])
    assert tool("/wall_e/docking_server").call("get_type_description", type_hash=type_.hash)["successful"]


@pytest.mark.parametrize(
    ("node", "hash_"), [("/hmrsim", CLOCK), ("/map_server", MAP), ("/wall_e/base_driver", BATTERY)]
)
def test_nodes_describe_the_types_of_topics(tool, node, hash_):
    assert tool(node).call("get_type_description", type_hash=hash_)["successful"]


# --- lifecycle ---------------------------------------------------------------------------------------------------


def test_a_deactivated_navigator_rejects_goals_until_it_is_activated(tool, fast, ros):
    tool, node = tool("/wall_e/bt_navigator"), ros(fast)
    drive, wait = (node.action(f"/wall_e/{name}").wait() for name in ("navigate_to_pose", "wait"))
    before = tool.state()
    deactivated = tool.change(DEACTIVATE), tool.state()
    goal, other = drive.send({}), wait.do({})
    activated = tool.change(ACTIVATE), tool.state()

    assert "active" == before
    assert (True, "inactive") == deactivated
    assert (False, SUCCEEDED) == (goal.accepted, other[0])
    assert (True, "active") == activated
    assert drive.send({}).accepted


def test_goals_end_when_their_node_is_deactivated(tool, live, ros):
    tool = Tool(ros(live), "/wall_e/behavior_server")
    goal = ros(live).action("/wall_e/wait").wait().send(LONG)
    result = goal.begin_result()
    changed = tool.change(label="deactivate")

    assert changed
    assert ABORTED == result.result(PATIENCE)["status"]
    assert tool.change(label="activate")


def test_available_and_all_transitions_are_listed(tool):
    tool = tool("/wall_e/planner_server")
    states = [(one["id"], one["label"]) for one in tool.call("get_available_states")["available_states"]]
    now = [one["transition"]["label"] for one in tool.call("get_available_transitions")["available_transitions"]]
    graph = tool.call("get_transition_graph")["available_transitions"]

    assert [(0, "unknown"), (1, "unconfigured"), (2, "inactive"), (3, "active"), (4, "finalized")] == states[:5]
    assert [(10, "configuring"), (15, "errorprocessing")] == [states[5], states[-1]]
    assert ["deactivate", "shutdown"] == now
    numbers = {one["transition"]["id"] for one in graph}
    assert {1, 2, 3, 4, 5, 6, 7, *(tens + units for tens in range(10, 70, 10) for units in range(3))} == numbers
    ends = {(one["start_state"]["label"], one["transition"]["label"]): one["goal_state"]["label"] for one in graph}
    assert "inactive" == ends["configuring", "transition_success"]
    assert "errorprocessing" == ends["activating", "transition_error"]
    assert "shuttingdown" == ends["active", "shutdown"]


def test_invalid_transitions_fail_and_keep_the_state(tool):
    tool = tool("/wall_e/waypoint_follower")

    assert [False, False, False] == [tool.change(ACTIVATE), tool.change(label="configure"), tool.change(99)]
    assert "active" == tool.state()


def test_a_lifecycle_manager_takes_a_robot_down_and_up(tool):
    tools = [tool(f"/wall_e/{name}") for name in NODES[:7]]
    steps = ("deactivate", "cleanup", "configure", "activate")
    with ThreadPoolExecutor() as pool:
        done = list(pool.map(lambda tool: [(tool.change(label=step), tool.state()) for step in steps], tools))

    assert [[(True, state) for state in ("inactive", "unconfigured", "inactive", "active")]] * len(tools) == done


def test_changes_of_state_are_in_the_trace(tmp_path):
    """A replay rejects the same goals."""
    path = tmp_path / "trace"
    with hosting(path) as host:
        host.start()
        with RosClient(host.endpoints[0]) as client:
            assert Tool(client, "/wall_e/behavior_server").change(DEACTIVATE)
            assert not client.action("/wall_e/wait").wait().send(LONG).accepted
        host.stop()

    text = path.read_text()
    assert '"command":"change_state"' in text
    assert replay(text.splitlines(keepends=True)).difference is None


# --- services that only some nodes have --------------------------------------------------------------------------


class Robot:
    """A ROS node that calls the services below a robot's name, in the layout of its distribution."""

    def __init__(self, client):
        self._client = client

    def call(self, name, **fields):
        of = {name: kind for node in nodes_of("wall_e", ACTIONS) for name, kind in own_services(node).items()}
        type_ = service_type(of[f"/wall_e/{name}"], self._client.distro)
        request = of[f"/wall_e/{name}"].Request.model_validate(fields, strict=False)
        return self._client.service(f"/wall_e/{name}", type_).wait().call(type_.request.encode(request))


@pytest.mark.parametrize(
    ("commands", "states"),
    [
        ([PAUSE], ["inactive", "inactive"]),
        ([PAUSE, RESUME], ["active", "active"]),
        ([RESET], ["unconfigured", "unconfigured"]),
        ([RESET, STARTUP], ["active", "active"]),
        ([SHUTDOWN], ["finalized", "finalized"]),
    ],
)
def test_a_lifecycle_manager_changes_all_its_nodes(fast, ros, commands, states):
    """BasicNavigator's lifecycleStartup and lifecycleShutdown; localization has another manager."""
    client = ros(fast)
    robot = Robot(client)
    succeeded = [robot.call("lifecycle_manager_navigation/manage_nodes", command=one)["success"] for one in commands]
    active = robot.call("lifecycle_manager_navigation/is_active")["success"]

    assert [True] * len(commands) == succeeded
    assert (states == ["active", "active"]) == active
    assert states == [Tool(client, f"/wall_e/{name}").state() for name in ("bt_navigator", "docking_server")]
    assert "active" == Tool(client, "/wall_e/amcl").state()


def test_a_node_that_was_shut_down_does_not_start_again(fast, ros):
    robot = Robot(ros(fast))
    manage = "lifecycle_manager_localization/manage_nodes"

    assert [True, False, True] == [robot.call(manage, command=one)["success"] for one in (SHUTDOWN, STARTUP, SHUTDOWN)]
    assert not robot.call("lifecycle_manager_localization/is_active")["success"]


@pytest.mark.parametrize("distro", ["jazzy", "kilted", "lyrical"])
def test_costmaps_have_the_walls_and_can_be_cleared(fast, ros, distro):
    robot = Robot(ros(fast, distro))
    costmap = robot.call("global_costmap/get_costmap")["map"]
    cells, size = costmap["data"], (costmap["metadata"]["size_x"], costmap["metadata"]["size_y"])
    cleared = [
        robot.call(f"{name}/clear_{kind}_{name}")
        for name in ("global_costmap", "local_costmap")
        for kind in ("entirely", "except", "around")
    ]

    assert (400, 200) == size
    assert (254, 0) == (cells[100 * 400 + 240], cells[0])
    assert all(one.get("success", distro != "lyrical") for one in cleared)


@pytest.mark.parametrize("distro", ["jazzy", "kilted", "lyrical"])
def test_a_path_is_valid_if_it_meets_no_wall(fast, ros, distro):
    robot = Robot(ros(fast, distro))

    def check(*points):
        poses = [{"pose": {"position": {"x": x, "y": y}}} for x, y in points]
        answer = robot.call("is_path_valid", path={"poses": poses})
        return answer["is_valid"], list(answer["invalid_pose_indices"])

    assert (True, []) == check((1.0, 1.0), (1.0, 9.0))
    # The pose in the solid, the one behind it, and the one behind the wall.
    assert (False, [1, 2, 3]) == check((5.0, 5.0), (7.0, 5.0), (9.0, 5.0), (15.0, 5.0))
    assert (False, []) == check()


@pytest.mark.parametrize(
    ("service", "file"),
    [("route_server/set_route_graph", "graph_filepath"), ("docking_server/reload_database", "filepath")],
)
def test_the_world_s_route_graph_and_docks_are_not_replaced(fast, ros, service, file):
    assert {"success": False} == Robot(ros(fast)).call(service, **{file: "/tmp/other"})
