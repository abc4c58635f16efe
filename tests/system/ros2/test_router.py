"""The simulator is the router that ROS expects, or joins an existing one, whatever the start order."""

from __future__ import annotations

import json
import logging
import socket
import subprocess
import sys
import threading
from contextlib import contextmanager
from types import SimpleNamespace

import pytest
import zenoh

from hmrsim_zenoh.errors import PortTaken, PrefixTaken
from hmrsim_zenoh.ros2.wires import RmwZenoh
from hmrsim_zenoh.wire.session import SessionOptions, open_client, open_server
from tests.patience import PATIENCE
from tests.served_world import served_world
from tests.system.ros2.processes import HMRSIM
from tests.wire.ros2.client import SUCCEEDED, RosClient, goal_to, open_session, statuses

KEY = "0/wall_e/here"
TOKEN = "@ros2_lv/0/here"

ROUTER = """
import json, sys, zenoh
config = zenoh.Config()
for key, value in json.loads(sys.argv[1]).items():
    config.insert_json5(key, json.dumps(value))
with zenoh.open(config):
    print("ready", flush=True)
    sys.stdin.read()
"""


@pytest.fixture
def options():
    """Return default options for a meeting point other than the usual one."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return SessionOptions(default=f"tcp/127.0.0.1:{probe.getsockname()[1]}")


@pytest.fixture
def router(options):
    """Start a router in another process, configured like rmw_zenohd, where ROS expects it."""
    config = {
        "mode": "router",
        "listen/endpoints": [options.default],
        "scouting/multicast/enabled": False,
        "routing/router/peers_failover_brokering": False,
        "timestamping/enabled": True,
    }
    command = [sys.executable, "-c", ROUTER, json.dumps(config)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert "ready\n" == process.stdout.readline()
        yield
        process.stdin.close()


@contextmanager
def simulator(options):
    """Open the part of a simulator that matters here: a service and a token."""
    session, endpoints = open_server(options, join=True)
    handler = zenoh.handlers.Callback(lambda query: query.reply(KEY, b"here"), indirect=False)
    with session:
        service = session.declare_queryable("0/**", handler, complete=True)
        token = session.liveliness().declare_token(TOKEN)
        yield SimpleNamespace(session=session, endpoints=endpoints)
        token.undeclare()
        service.undeclare()


def ros_node(options):
    """Return a session like that of a ROS node, which finds its router by name."""
    return open_session(options.default.replace("127.0.0.1", "localhost"))


def answer(session):
    """Return the reply of a service once the simulator is there."""
    there = threading.Event()
    handler = zenoh.handlers.Callback(lambda _sample: there.set(), indirect=False)
    watch = session.liveliness().declare_subscriber(TOKEN, handler, history=True)
    assert there.wait(PATIENCE)
    replies = session.get(KEY, target=zenoh.QueryTarget.ALL_COMPLETE, timeout=PATIENCE)
    told = [reply.ok.payload.to_string() for reply in replies]
    watch.undeclare()
    return told


def test_a_simulator_is_the_router_if_there_is_none(options):
    with simulator(options) as there:
        assert (options.default,) == there.endpoints


def test_a_ros_node_finds_a_running_simulator(options):
    with simulator(options), ros_node(options) as node:
        assert ["here"] == answer(node)


def test_a_ros_node_finds_a_simulator_that_starts_later(options):
    with ros_node(options) as node, simulator(options):
        assert ["here"] == answer(node)


def test_two_ros_nodes_find_each_other_by_the_simulator(options):
    router, _ = open_server(options, join=True)
    with router, ros_node(options) as node, simulator(SessionOptions(connect=(options.default,), mode="peer")):
        assert ["here"] == answer(node)


@pytest.mark.usefixtures("router")
def test_a_simulator_joins_a_running_router(options, caplog):
    with caplog.at_level(logging.INFO), simulator(options) as there:
        (endpoint,) = there.endpoints

    assert f"another Zenoh listens on {options.default}; joining it, and listening on {endpoint}" in caplog.text


@pytest.mark.usefixtures("router")
def test_a_ros_node_finds_a_simulator_that_has_joined(options):
    with simulator(options), ros_node(options) as node:
        assert ["here"] == answer(node)


@pytest.mark.usefixtures("router")
def test_a_ros_node_finds_a_simulator_that_joins_later(options):
    with ros_node(options) as node, simulator(options):
        assert ["here"] == answer(node)


@pytest.mark.usefixtures("router")
def test_a_tool_finds_a_simulator_that_has_joined(options):
    with simulator(options), open_client(options) as tool:
        assert ["here"] == answer(tool)


def test_a_second_simulator_joins_the_first(options):
    first, _ = open_server(options, join=True)
    with first, simulator(options) as second, ros_node(options) as node:
        assert [first.zid()] == second.session.info.routers_zid()
        assert ["here"] == answer(node)


@pytest.mark.usefixtures("router")
def test_a_ros_client_drives_a_robot_of_a_simulator_that_has_joined(options):
    served = served_world(options=options, wires=(RmwZenoh(),), real_time_factor=0)
    with served, RosClient(options.default) as client:
        action = client.action("/wall_e/navigate_to_pose").wait()
        goal = action.send(goal_to(5.0, 2.0))

        assert (SUCCEEDED, 0) == (goal.result()[0], goal.result()[1]["error_code"])
        assert (
            0.0
            == action.feedback.wait(lambda all_: all_ and not all_[-1]["feedback"]["distance_remaining"])[-1][
                "feedback"
            ]["distance_remaining"]
        )
        assert {goal.id: SUCCEEDED} == statuses(
            action.status.wait(lambda all_: all_ and SUCCEEDED in statuses(all_[-1]).values())[-1]
        )


@pytest.mark.usefixtures("router")
def test_the_command_line_finds_a_simulator_that_has_joined(options):
    with served_world(options=options, wires=(RmwZenoh(),)):
        listed = subprocess.run(
            [HMRSIM, "action", "list", "--connect", options.default], capture_output=True, text=True, check=True
        )

    assert "/wall_e/navigate_to_pose" in listed.stdout.splitlines()


def test_a_second_simulator_of_the_same_prefix_is_refused(options):
    """With ROS it joins the first one, detects the conflict, and ends."""
    with (
        served_world(options=options),
        pytest.raises(PrefixTaken, match="another simulator serves prefix 'hmrsim'"),
        served_world(options=options, wires=(RmwZenoh(),)),
    ):
        pytest.fail("it was served")


def test_simulators_in_several_domains_share_a_network(options, caplog):
    with (
        served_world(options=options, wires=(RmwZenoh(domain=3),), real_time_factor=0),
        served_world(options=options, wires=(RmwZenoh(domain=4),), real_time_factor=0),
    ):
        for domain in (3, 4):
            with RosClient(options.default, domain=domain) as client:
                assert SUCCEEDED == client.action("/wall_e/wait").wait().do({})[0]

    assert "another simulator has the prefix 'hmrsim'; using --prefix hmrsim_4" in caplog.text


def test_a_second_simulator_of_the_same_domain_is_refused(options):
    with (
        served_world(options=options, wires=(RmwZenoh(domain=3),)) as first,
        RosClient(first.connect[0], domain=3) as client,
    ):
        client.graph.wait(lambda tokens: any(token.endswith("/%/hmrsim") for token in tokens))
        with pytest.raises(PrefixTaken), served_world(options=options, wires=(RmwZenoh(domain=3),)):
            pytest.fail("it was served")


def test_a_simulator_takes_the_place_of_a_router_that_ends(options, caplog):
    router, _ = open_server(options, join=True)
    with served_world(options=options, wires=(RmwZenoh(),), real_time_factor=0):
        router.close()
        with RosClient(options.default) as client:
            assert SUCCEEDED == client.action("/wall_e/wait").wait().do({})[0]

    assert f"the router has ended; listening on {options.default} in its place" in caplog.text


@pytest.mark.usefixtures("router")
@pytest.mark.parametrize("named", ["listen", "mode", "join"])
def test_a_named_endpoint_or_the_mode_of_a_router_joins_no_router(options, named):
    """A taken port is an error, as without ROS."""
    asked = {
        "listen": SessionOptions(listen=(options.default,)),
        "mode": SessionOptions(default=options.default, mode="router"),
        "join": options,
    }[named]

    with pytest.raises(PortTaken, match=rf"{options.default} is in use; give another endpoint with --listen"):
        open_server(asked, join=named != "join")


@pytest.mark.parametrize("word", [b"", b"HTTP/1.0 400 Bad Request\r\n\r\n"])
def test_a_port_of_a_process_without_zenoh_is_taken(options, word):
    host, port = "127.0.0.1", int(options.default.rpartition(":")[2])
    with socket.create_server((host, port)) as other:
        threading.Thread(target=_say, args=(other, word), daemon=True).start()
        with pytest.raises(PortTaken, match=rf"{options.default} is in use"):
            open_server(options, join=True)
        other.shutdown(socket.SHUT_RDWR)


def _say(server, word):
    """Send a word to each client and hang up; without a word stay mute."""
    guests = []
    while True:
        try:
            guest, _ = server.accept()
        except OSError:
            break
        guests.append(guest)
        if word:
            guest.sendall(word)
            guest.close()
    for guest in guests:
        guest.close()
