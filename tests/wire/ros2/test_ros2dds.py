"""A client like Open-RMF's free_fleet drives simulated robots as if they were behind zenoh-bridge-ros2dds."""

from __future__ import annotations

import threading
import uuid
from contextlib import contextmanager

import pytest
import zenoh

from hmrsim.interfaces.sensor_msgs import BatteryState
from hmrsim.interfaces.tf2_msgs import TFMessage
from hmrsim_zenoh.errors import BadOptions
from hmrsim_zenoh.ros2.codec.types import message_type
from hmrsim_zenoh.ros2.wires import RmwZenoh, Ros2Dds
from hmrsim_zenoh.wire.session import open_client
from tests.served_world import served_world
from tests.simulation import SMALL_WORLD
from tests.wire.ros2.client import (
    ABORTED,
    CANCELED,
    CDR,
    EXECUTING,
    PATIENCE,
    SUCCEEDED,
    UNKNOWN,
    RosClient,
    get_state,
    goal_to,
    ros_action,
)

WORLD = {
    **SMALL_WORLD,
    "robot_types": {
        **SMALL_WORLD["robot_types"],
        "courier": {"components": {"battery": {"capacity": 1000.0, "initial_charge": 250.0}}},
    },
    "robots": {**SMALL_WORLD["robots"], "tb3": {"type": "courier", "at": "home", "yaw": 1.5}},
}
SOON = 0.3
"""Wall seconds after which free_fleet gives up asking for a result, to ask again later."""


class FreeFleet:
    """The requests and subscriptions of free_fleet's adapter for one robot, with a default session.

    Args:
        options: Where the simulator is.
        robot: The robot.
    """

    def __init__(self, options, robot="tb3"):
        self.options = options
        self.session = open_client(options)
        self.robot = robot
        self._changed = threading.Condition()
        self.heard = {}
        self._watch("tf", message_type(TFMessage, "jazzy"))
        self._watch("battery_state", message_type(BatteryState, "jazzy"))
        self._watch("navigate_to_pose/_action/feedback", ros_action("navigate_to_pose").feedback)

    def __enter__(self):
        return self

    def __exit__(self, *_error):
        self.session.close()

    def _watch(self, topic, type_):
        def take(sample):
            with self._changed:
                self.heard.setdefault(topic, []).append(type_.decode(sample.payload.to_bytes()))
                self._changed.notify_all()

        self.session.declare_subscriber(f"{self.robot}/{topic}", zenoh.handlers.Callback(take, indirect=False))

    def wait(self, topic, until=bool):
        """Return all messages of a topic, once *until* holds for them."""
        with self._changed:
            assert self._changed.wait_for(lambda: until(self.heard.get(topic, [])), PATIENCE), topic
            return list(self.heard[topic])

    def ask(self, service, payload, **options):
        """Return the payload of the one reply, or None after a timeout; free_fleet can't handle errors."""
        replies = list(self.session.get(f"{self.robot}/{service}", payload=payload, **options))
        errors = [reply.err.payload.to_string() for reply in replies if not reply.ok]
        assert set(errors) <= {"Timeout"}
        found = [reply.ok.payload.to_bytes() for reply in replies if reply.ok]
        assert len(found) <= 1
        return found[0] if found else None

    def send(self, action, goal, goal_id):
        """Send a goal; return whether it was accepted."""
        service = ros_action(action).send_goal
        payload = service.request.encode({"goal_id": {"uuid": list(goal_id)}, "goal": goal})
        answer = self.ask(f"{action}/_action/send_goal", payload)
        return service.response.decode(answer)["accepted"]

    def navigate(self, x, y):
        """Send the robot somewhere; return the goal's id."""
        goal_id = uuid.uuid4().bytes
        assert self.send("navigate_to_pose", goal_to(x, y), goal_id)
        return goal_id

    def status(self, goal_id, action="navigate_to_pose", **options):
        """Return the status from get_result, the only field that free_fleet reads."""
        answer = self.ask(f"{action}/_action/get_result", CDR + goal_id, **options)
        return answer and answer[4]

    def cancel_all(self):
        """Cancel all goals; return the code, and how many are canceling."""
        service = ros_action("navigate_to_pose").cancel_goal
        answer = service.response.decode(self.ask("navigate_to_pose/_action/cancel_goal", CDR + bytes(24)))
        return answer["return_code"], len(answer["goals_canceling"])


@contextmanager
def serving(**settings):
    """Serve a robot and wait for its transform, as free_fleet's adapter does first."""
    with served_world(WORLD, wires=(Ros2Dds(),), **settings) as options, FreeFleet(options) as client:
        client.wait("tf")
        yield client


@pytest.fixture
def fleet():
    """Return a robot in real time."""
    with serving() as client:
        yield client


@pytest.fixture
def fast():
    """Return a robot whose goals take little wall time."""
    with serving(real_time_factor=20) as client:
        yield client


def test_a_goal_succeeds_and_the_transforms_show_the_robot_there(fast):
    assert SUCCEEDED == fast.status(fast.navigate(5.0, 2.0))

    assert fast.wait("tf", lambda all_: all_ and 5.0 == place(all_[-1])["x"])


def test_a_goal_that_was_sent_before_is_rejected(fast):
    """The reply is not an error."""
    goal_id = fast.navigate(5.0, 2.0)

    assert not fast.send("navigate_to_pose", goal_to(1.0, 2.0), goal_id)


def test_a_goal_that_can_not_be_reached_is_aborted(fast):
    """The client free_fleet then plans again."""
    assert ABORTED == fast.status(fast.navigate(100.0, 2.0))


def test_an_unknown_goal_has_no_status(fast):
    assert UNKNOWN == fast.status(bytes(range(16)))


def test_feedback_has_the_remaining_distance(fast):
    goal_id = fast.navigate(5.0, 2.0)

    told = fast.wait(
        "navigate_to_pose/_action/feedback", lambda all_: all_ and not all_[-1]["feedback"]["distance_remaining"]
    )

    assert {goal_id} == {bytes(one["goal_id"]["uuid"]) for one in told}
    assert {"sec": 0, "nanosec": 0} == told[-1]["feedback"]["estimated_time_remaining"]


def test_a_result_request_can_be_repeated_until_the_goal_ends(fleet):
    goal_id = fleet.navigate(5.0, 2.0)

    early = [fleet.status(goal_id, timeout=SOON) for _ in range(3)]

    assert [None, None, None] == early
    assert SUCCEEDED == fleet.status(goal_id, timeout=PATIENCE)


def test_a_zero_id_and_stamp_cancels_all_goals(fleet):
    """This is how free_fleet stops a robot."""
    goal_id = fleet.navigate(5.0, 2.0)

    assert (0, 1) == fleet.cancel_all()

    assert CANCELED == fleet.status(goal_id)


def test_a_cancel_without_goals_is_not_an_error(fleet):
    assert (0, 0) == fleet.cancel_all()


def test_transforms_are_published_at_rest_without_a_namespace(fleet):
    """The client free_fleet adds the namespace itself."""
    (footprint, base) = fleet.wait("tf")[0]["transforms"]

    assert ("map", "base_footprint") == (footprint["header"]["frame_id"], footprint["child_frame_id"])
    assert ("base_footprint", "base_link") == (base["header"]["frame_id"], base["child_frame_id"])
    assert {"x": 1.0, "y": 2.0, "z": 0.0} == footprint["transform"]["translation"]
    assert {"x": 0.0, "y": 0.0, "z": 0.0} == base["transform"]["translation"]


def test_a_battery_publishes_its_charge_between_0_and_1(fleet):
    assert 0.25 == pytest.approx(fleet.wait("battery_state")[0]["percentage"], abs=0.01)


def test_a_docking_goal_of_the_real_layout_is_read(fast):
    goal = {
        "use_dock_id": True,
        "dock_id": "nowhere",
        "dock_pose": goal_to(0.0, 0.0)["pose"],
        "dock_type": "",
        "max_staging_time": 1000.0,
        "navigate_to_staging_pose": True,
    }
    goal_id = uuid.uuid4().bytes

    assert fast.send("dock_robot", goal, goal_id)
    assert ABORTED == fast.status(goal_id, "dock_robot")


def test_attachments_of_bridges_are_ignored(fast):
    for attached in (b"", b"rqh", bytes(33)):
        answer = fast.ask("navigate_to_pose/_action/get_result", CDR + bytes(range(16)), attachment=attached)

        assert UNKNOWN == answer[4], attached


@pytest.mark.parametrize(
    ("verb", "refused"), [("send_goal", b"\0"), ("cancel_goal", b"\1"), ("get_result", bytes([UNKNOWN]))]
)
def test_malformed_requests_are_rejected_without_an_error(fast, verb, refused):
    for payload in (b"", b"\0", CDR, CDR + bytes(3), b"\xff" * 400):
        answer = fast.ask(f"navigate_to_pose/_action/{verb}", payload)

        assert CDR + refused == answer[:5], payload


def test_a_node_is_active(fleet):
    answer = fleet.ask("bt_navigator/get_state", CDR + b"\0")

    assert {"current_state": {"id": 3, "label": "active"}} == get_state().response.decode(answer)


def test_the_simulator_does_not_answer_for_a_real_robot_behind_a_bridge(fast):
    bridge = open_client(fast.options)
    handler = zenoh.handlers.Callback(lambda query: query.reply(query.key_expr, b"real"), indirect=False)
    with bridge:
        service = bridge.declare_queryable("real/navigate_to_pose/_action/send_goal", handler)
        real = FreeFleet(fast.options, "real")
        with real:
            told = real.ask("navigate_to_pose/_action/send_goal", CDR)
        service.undeclare()

    assert b"real" == told


def test_a_ros_node_watches_and_cancels_a_goal_of_free_fleet():
    with (
        served_world(WORLD, wires=(RmwZenoh(), Ros2Dds())) as options,
        FreeFleet(options) as client,
        RosClient(options.connect[0]) as node,
    ):
        client.wait("tf")
        goal_id = client.navigate(5.0, 2.0)
        action = node.action("/tb3/navigate_to_pose").wait()
        action.status.wait(lambda told: told and [EXECUTING] == [one["status"] for one in told[-1]["status_list"]])

        assert (0, [goal_id]) == action.cancel(goal_id)
        assert CANCELED == client.status(goal_id)


def test_a_robot_named_like_the_prefix_is_refused():
    """Its keys would be those of the JSON wire."""
    world = {**SMALL_WORLD, "robots": {"hmrsim": {"type": "nurse", "at": "home"}}, "remap": {}}

    with (
        pytest.raises(BadOptions, match="--prefix 'hmrsim' collides with the keys of robot 'hmrsim'; use another"),
        served_world(world, wires=(Ros2Dds(),)),
    ):
        pytest.fail("it was served")


def place(message):
    """Return a robot's position by its transforms."""
    return message["transforms"][0]["transform"]["translation"]
