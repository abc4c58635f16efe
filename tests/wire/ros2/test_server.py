"""A served world and a ROS client over Zenoh: goals, cancels and results, beside the JSON wire."""

from __future__ import annotations

import functools
import json
import threading
import time
import uuid
from contextlib import contextmanager
from types import SimpleNamespace

import pytest

from hmrsim.interfaces.nav2_msgs import Wait
from hmrsim.services import registry as all_services
from hmrsim.settings.run import RunSettings
from hmrsim.world import World
from hmrsim.world_checks import world_hash
from hmrsim_zenoh.errors import BadOptions
from hmrsim_zenoh.hosting.host import Host
from hmrsim_zenoh.ros2.codec.types import service_type
from hmrsim_zenoh.ros2.wires import RmwZenoh, Ros2Dds
from hmrsim_zenoh.wire.session import SessionOptions
from tests.patience import PATIENCE
from tests.served_world import served_world
from tests.simulation import SMALL_WORLD
from tests.wire.ros2.client import ABORTED, CANCELED, CDR, SUCCEEDED, UNKNOWN, RosClient, get_state, goal_to

SMALL = World.model_validate(SMALL_WORLD)
LOADED = SimpleNamespace(world=SMALL, hash=world_hash(SMALL), warnings=(), path=None)
WAIT = "/wall_e/wait"
LONG = {"time": {"sec": 3600}}


@pytest.fixture(scope="module")
def world():
    """Return the endpoint of a world that is served in real time."""
    with served_world(wires=(RmwZenoh(), Ros2Dds())) as options:
        yield options.connect[0]


@pytest.fixture
def client(world):
    with RosClient(world) as made:
        yield made


@pytest.fixture
def wait(client):
    """Return a client of `wait`, and cancel its goals at the end."""
    made = client.action(WAIT).wait()
    yield made
    made.cancel()


def ask_json(client, key, payload):
    """Return the answer of the JSON wire."""
    (reply,) = client.session.get(f"hmrsim/{key}", payload=json.dumps(payload).encode(), timeout=PATIENCE)
    return json.loads(reply.ok.payload.to_string())


class TestGoals:
    def test_a_subscriber_gets_all_feedback_and_statuses_of_its_next_goal(self, wait):
        goal = wait.send(LONG)
        feedback = wait.wait_for_feedback(goal.id)
        wait.wait_for_status(goal.id, 2)

        assert feedback["time_left"]["sec"] >= 3599

    @pytest.mark.parametrize("goal_id", [bytes(16), b"duplicate goal id"[:16]])
    def test_a_zero_id_and_a_used_id_are_rejected(self, wait, goal_id):
        wait.send(LONG, b"duplicate goal i")
        goal = wait.send(LONG, goal_id)

        assert not goal.accepted

    def test_rejections_are_logged(self, wait, caplog):
        """ROS's reply can't carry the reason."""
        wait.send(LONG, bytes(16))

        assert any("rejected: the goal id is zero" in message for message in caplog.messages)


class TestCancels:
    def test_a_goal_is_canceled_by_id(self, wait):
        goal = wait.send(LONG)

        assert (0, [goal.id]) == goal.cancel()
        assert CANCELED == goal.result()[0]

    def test_all_goals_are_canceled_without_id_and_time(self, wait):
        goal = wait.send(LONG)

        assert (0, [goal.id]) == wait.cancel()

    def test_goals_accepted_up_to_a_time_are_canceled(self, wait):
        goal = wait.send(LONG)
        early = wait.cancel(stamp=(0, 1))

        assert (0, []) == early
        assert (0, [goal.id]) == wait.cancel(stamp=goal.stamp)


class TestBothWires:
    def test_json_cancels_a_goal_of_ros(self, client, wait):
        goal = wait.send(LONG)
        result = goal.begin_result()
        answer = ask_json(client, "wall_e/wait/_action/cancel_goal", {"goal_info": {"goal_id": goal.id.hex()}})

        assert [goal.id.hex()] == [each["goal_id"] for each in answer["goals_canceling"]]
        assert CANCELED == result.result(PATIENCE)["status"]

    def test_ros_cancels_a_goal_of_json(self, client, wait):
        goal_id = uuid.uuid4()
        ask_json(client, "wall_e/wait/_action/send_goal", {"goal_id": goal_id.hex, "goal": LONG})

        assert (0, [goal_id.bytes]) == wait.cancel(goal_id.bytes)
        assert CANCELED == ask_json(client, "wall_e/wait/_action/get_result", {"goal_id": goal_id.hex})["status"]

    def test_ros_watches_a_goal_of_json(self, client, wait):
        goal_id = uuid.uuid4()
        ask_json(client, "wall_e/wait/_action/send_goal", {"goal_id": goal_id.hex, "goal": LONG})
        wait.wait_for_status(goal_id.bytes, 2)

        assert wait.wait_for_feedback(goal_id.bytes)["time_left"]["sec"] >= 3599


@contextmanager
def serving(**settings):
    with Host(
        LOADED, SessionOptions(listen=("tcp/127.0.0.1:0",)), RunSettings(**settings), wires=(RmwZenoh(),)
    ) as host:
        host.start()
        yield host


def until(condition):
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


def test_the_result_request_of_a_client_that_has_gone_is_withdrawn():
    """Its goal continues, and other clients get the result."""
    with serving() as host, RosClient(host.endpoints[0]) as watcher:
        watched = watcher.action(WAIT).wait()
        with RosClient(host.endpoints[0]) as leaver:
            goal = leaver.action(WAIT).wait().send(LONG)
            goal.begin_result()
            mine = watched.get_result.begin(CDR + goal.id)
            # The simulation's thread registers the goal, maybe after its answer was sent.
            served = functools.partial(host.simulator.dispatcher.servers.goal, "wall_e", "wait", goal.id.hex())
            until(lambda: (one := served()) is not None and len(one.waiting) == 2)
        until(lambda: len(served().waiting) == 1)
        watched.cancel(goal.id)

        assert CANCELED == mine.result(PATIENCE)["status"]


@pytest.mark.parametrize("settings", [{}, {"clock": "lockstep"}, {"real_time_factor": 0.0}])
def test_a_cancel_does_not_overtake_its_goal(settings):
    """JSON requests in between are answered as well."""
    with serving(**settings) as host, RosClient(host.endpoints[0]) as client:
        wait = client.action(WAIT).wait()
        ids = [uuid.uuid4().bytes for _ in range(50)]
        canceled = []
        for goal_id in ids:
            goal = {"goal_id": {"uuid": goal_id}, "goal": Wait.Goal.model_validate(LONG)}
            wait.send_goal.begin(wait.type.send_goal.request.encode(goal))
            canceled.append(wait.cancel_goal.begin(CDR + goal_id + bytes(8)))
            ask_json(client, "_world/get_entities", {})
        codes = {each.result(PATIENCE)["return_code"] for each in canceled}

        assert {0} == codes


def test_a_robot_that_ros_spawns_is_driven_by_ros():
    spawn = all_services()["spawn_entity"]
    with serving() as host, RosClient(host.endpoints[0]) as client:
        service = client.service("/spawn_entity", service_type(spawn.ros, "jazzy"))
        where = {"pose": {"position": {"x": 15.0, "y": 8.0}}}
        request = {"name": "helper", "uri": "robot_type:fetcher", "initial_pose": where}
        spawned = service.wait().call(service.type.request.encode(spawn.request.model_validate(request)))
        navigate = client.action("/helper/navigate_to_pose").wait()

        assert "helper" == spawned["entity_name"]
        assert SUCCEEDED == navigate.do(goal_to(15.0, 8.0))[0]


def test_an_unreachable_robot_has_no_tokens_rejects_goals_and_has_unknown_states():
    with serving() as host, RosClient(host.endpoints[0]) as client:
        wait = client.action(WAIT).wait()
        state = client.service("/wall_e/amcl/get_state", get_state()).wait()
        ask_json(client, "_world/inject_fault", {"type": "messages_lost", "robot": "wall_e"})
        client.graph.wait(lambda tokens: not any("/%wall_e/" in token for token in tokens))
        lost = wait.send(LONG).accepted, state.call(CDR + b"\0")["current_state"]["id"]
        ask_json(client, "_world/clear_fault", {"type": "messages_lost"})
        wait.wait()

        assert (False, 0) == lost
        assert (True, 3) == (wait.send(LONG).accepted, state.call(CDR + b"\0")["current_state"]["id"])


def test_a_client_that_waits_at_the_end_gets_an_aborted_result():
    with serving() as host:
        client = RosClient(host.endpoints[0])
        wait = client.action(WAIT).wait()
        result = wait.send(LONG).begin_result()
        # Answered after the request before it.
        wait.cancel(uuid.uuid4().bytes)
    answer = result.result(PATIENCE)
    client.close()

    assert ABORTED == answer["status"]
    assert "the simulator was stopped" == answer["result"]["error_msg"]


def test_requests_after_the_end_are_answered():
    with serving(duration=0.1) as host, RosClient(host.endpoints[0]) as client:
        wait = client.action(WAIT)
        assert host.wait(PATIENCE)
        accepted = wait.send(LONG).accepted
        status = wait.get_result.call(CDR + uuid.uuid4().bytes)["status"]

    assert (False, UNKNOWN) == (accepted, status)


def test_no_thread_is_left():
    """A Zenoh thread that outlives Python's end would abort the process."""
    before = set(threading.enumerate())
    with serving() as host, RosClient(host.endpoints[0]) as client:
        client.action(WAIT).wait().do({"time": {"sec": 0}})
        during = {thread.name for thread in set(threading.enumerate()) - before}
    left = {thread.name for thread in set(threading.enumerate()) - before}

    assert host.error is None
    assert {"hmrsim-queries", "hmrsim-ros2-tokens"} <= during
    assert not {"hmrsim-queries", "hmrsim-ros2-tokens"} & left


def test_a_prefix_that_is_a_domain_is_refused():
    """The keys of both wires would begin alike."""
    options = SessionOptions(listen=("tcp/127.0.0.1:0",), prefix="7/robots")
    with pytest.raises(BadOptions, match="--prefix '7/robots' collides with the keys of ROS domain 7; use another"):
        Host(LOADED, options, wires=(RmwZenoh(7),))
