"""``hmrsim topic``, with a simulator."""

from __future__ import annotations

import json
import signal

import pytest

from hmrsim.cli import connection, main, topic
from hmrsim_zenoh.wire.session import SessionOptions, open_client


def test_topics_are_listed_with_those_of_the_world_last(endpoint, capsys):
    code = main(["topic", "list", "--show-types", "--connect", endpoint])

    lines = capsys.readouterr().out.splitlines()
    assert 0 == code
    assert "/wall_e/odom [nav_msgs/msg/Odometry]" == lines[0]
    assert "/_world/clock [rosgraph_msgs/msg/Clock]" in lines


def test_json_marks_latched_topics(endpoint, capsys):
    main(["topic", "list", "--json", "--connect", endpoint])

    latched = {one["name"]: one["latched"] for one in json.loads(capsys.readouterr().out)}
    assert (True, False) == (latched["/_world/info"], latched["/_world/events"])


def test_echo_prints_the_latest_message_of_a_latched_topic_at_once(endpoint, capsys):
    code = main(["topic", "echo", "/wall_e/wait/_action/status", "--once", "--connect", endpoint])

    assert 0 == code
    assert "status_list: []\n---\n" == capsys.readouterr().out


def test_echo_prints_one_field(endpoint, capsys):
    for words in ([], ["--json"]):
        main(["topic", "echo", "/wall_e/odom", "--once", "--field", "header.frame_id", "--connect", endpoint, *words])

    assert 'map\n---\n"map"\n' == capsys.readouterr().out


def test_echo_prints_the_current_tree_of_a_controller(endpoint, capsys):
    key = "hmrsim/wall_e/_tree"
    with open_client(SessionOptions(connect=(endpoint,))) as session:
        session.declare_queryable(key, lambda query: query.reply(key, '{"status": "RUNNING"}'))
        code = main(["topic", "echo", "/wall_e/_tree", "--once", "--connect", endpoint])

    assert 0 == code
    assert "status: RUNNING\n---\n" == capsys.readouterr().out


def test_echo_shows_a_controller_that_starts_later(endpoint, capsys):
    with open_client(SessionOptions(connect=(endpoint,))) as session:
        publisher = session.declare_publisher("hmrsim/wall_e/_tree")
        publisher.declare_matching_listener(lambda _status: publisher.put('{"status": "RUNNING"}'))
        code = main(["topic", "echo", "/wall_e/_tree", "--once", "--connect", endpoint])

    assert 0 == code
    assert "status: RUNNING\n---\n" == capsys.readouterr().out


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
