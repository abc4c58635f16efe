"""``hmrsim topic``, with a simulator."""

from __future__ import annotations

import json
import signal

import pytest

from hmrsim.cli import connection, main, topic
from hmrsim_zenoh.wire.session import SessionOptions, open_client


def test_topics_are_listed_with_those_of_the_world_last(run):
    code, out, _ = run("topic", "list", "--show-types")

    assert (0, "/wall_e/odom [nav_msgs/msg/Odometry]") == (code, out.splitlines()[0])
    assert "/_world/clock [rosgraph_msgs/msg/Clock]" in out.splitlines()


def test_json_marks_latched_topics(run):
    latched = {one["name"]: one["latched"] for one in json.loads(run("topic", "list", "--json")[1])}

    assert (True, False) == (latched["/_world/info"], latched["/_world/events"])


def test_echo_prints_the_latest_message_of_a_latched_topic_at_once(run):
    assert (0, "status_list: []\n---\n") == run("topic", "echo", "/wall_e/wait/_action/status", "--once")[:2]


def test_echo_prints_one_field(run):
    words = ("topic", "echo", "/wall_e/odom", "--once", "--field", "header.frame_id")

    assert ["map\n---\n", '"map"\n'] == [run(*words)[1], run(*words, "--json")[1]]


def test_echo_prints_the_current_tree_of_a_controller(endpoint, run):
    key = "hmrsim/wall_e/_tree"
    with open_client(SessionOptions(connect=(endpoint,))) as session:
        session.declare_queryable(key, lambda query: query.reply(key, '{"status": "RUNNING"}'))

        assert (0, "status: RUNNING\n---\n") == run("topic", "echo", "/wall_e/_tree", "--once")[:2]


def test_echo_shows_a_controller_that_starts_later(endpoint, run):
    with open_client(SessionOptions(connect=(endpoint,))) as session:
        publisher = session.declare_publisher("hmrsim/wall_e/_tree")
        publisher.declare_matching_listener(lambda _status: publisher.put('{"status": "RUNNING"}'))

        assert (0, "status: RUNNING\n---\n") == run("topic", "echo", "/wall_e/_tree", "--once")[:2]


@pytest.mark.parametrize("command", ["echo", "hz"])
def test_ctrl_c_ends_an_echo_with_0(command, endpoint, start):
    process = start("topic", command, "/_world/clock", "--json", "--connect", endpoint)
    lines = [json.loads(process.stdout.readline()) for _ in range(2)]
    process.send_signal(signal.SIGINT)

    assert 0 == process.wait()
    assert {"clock"} if command == "echo" else {"average_rate", "min", "max", "std_dev", "window"} == (set(lines[1]))


def test_a_killed_simulator_ends_the_echo_with_3(start, monkeypatch):
    simulator = start("run", "scenario1", "--listen", "tcp/127.0.0.1:0")
    endpoint = simulator.stdout.readline().split()[1]
    monkeypatch.setattr(connection, "_GRACE", 0.2)
    monkeypatch.setattr(topic, "_print", lambda *_args, **_options: simulator.kill())

    assert 3 == main(["topic", "echo", "/_world/clock", "--connect", endpoint])
