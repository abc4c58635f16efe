"""``hmrsim topic``, with a simulator."""

from __future__ import annotations

import json
import signal

import pytest

from hmrsim.cli import connection, main, topic
from hmrsim_zenoh.wire.session import SessionOptions, open_client


def test_no_simulator_is_3(capsys):
    """Without a simulator there is one line of advice."""
    code = main(["topic", "list", "--connect", "tcp/127.0.0.1:1", "--timeout", "0.3"])

    assert 3 == code
    assert "hmrsim run WORLD" in capsys.readouterr().err


def test_topics_are_listed(endpoint, capsys):
    """One name a line, the world's last."""
    code = main(["topic", "list", "--show-types", "--connect", endpoint])

    lines = capsys.readouterr().out.splitlines()
    assert 0 == code
    assert "/wall_e/odom [nav_msgs/msg/Odometry]" == lines[0]
    assert "/_world/clock [rosgraph_msgs/msg/Clock]" in lines


def test_topics_as_json(endpoint, capsys):
    """Programs see which are latched."""
    main(["topic", "list", "--json", "--connect", endpoint])

    latched = {one["name"]: one["latched"] for one in json.loads(capsys.readouterr().out)}
    assert (True, False) == (latched["/_world/info"], latched["/_world/events"])


def test_echo_of_a_latched_topic(endpoint, capsys):
    """The latest comes at once, as a YAML document."""
    code = main(["topic", "echo", "/wall_e/wait/_action/status", "--once", "--connect", endpoint])

    assert 0 == code
    assert "status_list: []\n---\n" == capsys.readouterr().out


def test_one_field_of_a_topic(endpoint, capsys):
    """It is printed alone, as YAML or as JSON."""
    for words in ([], ["--json"]):
        main(["topic", "echo", "/wall_e/odom", "--once", "--field", "header.frame_id", "--connect", endpoint, *words])

    assert 'map\n---\n"map"\n' == capsys.readouterr().out


def test_echo_of_a_tree_that_can_be_got(endpoint, capsys):
    """A controller answers with its tree as it is."""
    key = "hmrsim/wall_e/_tree"
    with open_client(SessionOptions(connect=(endpoint,))) as session:
        session.declare_queryable(key, lambda query: query.reply(key, '{"status": "RUNNING"}'))
        code = main(["topic", "echo", "/wall_e/_tree", "--once", "--connect", endpoint])

    assert 0 == code
    assert "status: RUNNING\n---\n" == capsys.readouterr().out


def test_echo_of_a_tree_before_there_is_one(endpoint, capsys):
    """The echo also shows a controller that starts later."""
    with open_client(SessionOptions(connect=(endpoint,))) as session:
        publisher = session.declare_publisher("hmrsim/wall_e/_tree")
        publisher.declare_matching_listener(lambda _status: publisher.put('{"status": "RUNNING"}'))
        code = main(["topic", "echo", "/wall_e/_tree", "--once", "--connect", endpoint])

    assert 0 == code
    assert "status: RUNNING\n---\n" == capsys.readouterr().out


@pytest.mark.parametrize("command", ["echo", "hz"])
def test_following_a_topic_until_ctrl_c(command, endpoint, start):
    """What follows a topic ends with 0 on Ctrl-C."""
    process = start("topic", command, "/_world/clock", "--json", "--connect", endpoint)
    lines = [json.loads(process.stdout.readline()) for _ in range(2)]
    process.send_signal(signal.SIGINT)

    assert 0 == process.wait()
    assert {"clock"} if command == "echo" else {"average_rate", "min", "max", "std_dev", "window"} == (set(lines[1]))


def test_a_simulator_that_dies_ends_its_echo(start, monkeypatch):
    """An echo of a topic of a killed simulator exits with 3, shortly after the grace period."""
    simulator = start("run", "scenario1", "--listen", "tcp/127.0.0.1:0")
    endpoint = simulator.stdout.readline().split()[1]
    monkeypatch.setattr(connection, "_GRACE", 0.2)
    monkeypatch.setattr(topic, "_print", lambda *_args, **_options: simulator.kill())

    assert 3 == main(["topic", "echo", "/_world/clock", "--connect", endpoint])
