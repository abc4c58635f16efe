"""The short commands for robots, faults and time of a running simulation."""

from __future__ import annotations

import json
import re

import pytest

from hmrsim.cli import main


def test_robots_are_listed_with_place_and_state(run):
    code, out, _ = run("robot", "list")

    assert (0, ["name", "type", "at", "battery", "state"]) == (code, out.splitlines()[0].split())
    assert "wall_e" in out


def test_a_robot_is_idle_after_its_goal(run):
    assert 0 == run("action", "send-goal", "/wall_e/wait", "{time: {sec: 1}}")[0]

    assert re.search("idle at .*: it has had no goal since wait SUCCEEDED at ", run("robot", "list")[1])


def test_a_fault_is_injected_listed_and_cleared_by_name_or_type(run):
    assert 0 == run("fault", "inject", "breakdown", "robot=wall_e", "duration=100000")[0]
    assert ["breakdown_1"] == [fault["name"] for fault in json.loads(run("fault", "list", "--json")[1])]
    assert "breakdown" in run("robot", "list")[1]
    assert (0, "cleared: breakdown_1\n", "") == run("fault", "clear", "breakdown")
    assert (0, "there is no fault to clear\n", "") == run("fault", "clear")
    assert (0, "no fault is active or scheduled\n", "") == run("fault", "list")


def test_why_a_robot_stands_is_explained(run):
    code, idle, _ = run("explain", "--robot", "wall_e")
    run("fault", "inject", "breakdown", "robot=wall_e", "duration=100000")
    broken = json.loads(run("explain", "--robot", "wall_e", "--json")[1])
    run("fault", "clear")

    assert 0 == code
    assert "it has had no goal" in idle
    assert "What would help: its controller has to send it a goal" in idle
    assert [("wall_e", "disabled")] == [(link["robot"], link["kind"]) for link in broken["links"]]
    assert broken["faults"][0].startswith("The fault breakdown_1 (breakdown) ends at 100")
    assert (1, "hmrsim: no robot 'wally'; did you mean 'wall_e'?\n") == run("explain", "--robot", "wally")[::2]


def test_no_robot_waits(run):
    assert (0, "no robot waits; `hmrsim robot list` shows what each one does\n", "") == run("explain")
    assert [] == json.loads(run("explain", "--json")[1])


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (["inject", "breakdwn"], 2, "no fault 'breakdwn'; did you mean 'breakdown'?"),
        (["inject", "breakdown", "wall_e"], 2, "'wall_e': expected KEY=VALUE, such as robot=mocha"),
        (["inject", "breakdown", "robot=[1"], 2, "'robot=[1': '[1' is not valid YAML"),
        (["inject", "breakdown", "robot=wally"], 1, "no robot 'wally'; did you mean 'wall_e'?"),
        (["clear", "slip_7"], 1, "no fault 'slip_7' is active or scheduled; there is none"),
    ],
)
def test_an_unknown_fault_is_an_error_with_a_remedy(run, words, code, message):
    done, _, errors = run("fault", *words)

    assert code == done
    assert message in errors


def test_time_is_paused_stepped_and_resumed(run):
    assert run("time", "pause")[1].endswith(", paused\n")
    before = json.loads(run("time", "show", "--json")[1])["now"]
    run("time", "step", "5")
    after = json.loads(run("time", "show", "--json")[1])["now"]
    assert 0.5 == pytest.approx(after - before)
    assert not run("time", "resume")[1].endswith("paused\n")
    assert "10 times real time" in run("time", "speed", "10")[1]


def test_a_step_of_a_running_simulation_is_refused_with_a_remedy(run):
    assert (1, "", "hmrsim: the simulation is not paused; pause it first\n") == run("time", "step")


def test_topics_of_actions_are_hidden(run):
    assert "/_action/" not in run("topic", "list")[1]
    assert "/wall_e/wait/_action/status" in run("topic", "list", "-a")[1].splitlines()


def test_topic_type_and_service_type_print_the_type(run):
    assert "Type: nav_msgs/msg/Odometry" in run("topic", "info", "/wall_e/odom")[1]
    assert "nav_msgs/msg/Odometry\n" == run("topic", "type", "wall_e/odom")[1]
    assert "hmrsim_msgs/srv/InjectFault\n" == run("service", "type", "/_world/inject_fault")[1]


def test_ros2s_spelling_send_goal_with_an_underscore_is_accepted(run):
    assert run("action", "send_goal", "/wall_e/wait", "{}")[1].endswith("SUCCEEDED\n")


def test_a_goal_in_lockstep_is_refused_at_once_with_a_remedy(start, capsys):
    """The command would wait forever, as it does not take part in lockstep."""
    with start("run", "scenario1", "--clock", "lockstep", "--listen", "tcp/127.0.0.1:0") as process:
        where = process.stdout.readline().split()[1]
        code = main(["action", "send-goal", "/wall_e/wait", "{}", "--connect", where])

        assert 1 == code
        assert "time stands, as in lockstep no controller takes part: start one" in capsys.readouterr().err
        process.kill()
