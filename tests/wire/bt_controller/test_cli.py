"""The command line: what it prints, and its exit codes."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from bt_controller.cli import main
from bt_controller.coverage import TreeCoverage
from hmrsim_zenoh.client.client import Client
from tests.served_world import served_world

GO = "bt_controller.examples:go_to_pose"


@pytest.fixture
def simulator(client, monkeypatch):
    """Replace the client with a fake one, whose goals succeed at once unless a test says otherwise."""

    class Connected(type(client)):
        def __init__(self, options, *, clock, name):
            self.__dict__ = client.__dict__
            self.options = options
            self.part = (clock, name)

        def __enter__(self):
            return self

        def __exit__(self, *error):
            pass

        def wait_for_simulator(self, timeout):
            pass

    client.session.robot = lambda goal: goal.succeed()
    monkeypatch.setattr("hmrsim_zenoh.client.client.Client", Connected)
    return client


class TestRun:
    @pytest.mark.usefixtures("simulator")
    def test_a_tree_that_succeeds_prints_its_stages_and_exits_with_0(self, capsys):
        code = main(["run", GO, "--robot", "wall_e"])

        out, err = capsys.readouterr()
        assert (code, err) == (0, "")
        assert "        --> GoToPoseAction [✓] -- successfully completed\n" in out
        assert "        --> CheckArrived [✓] -- 'arrived' comparison succeeded" in out
        assert out.endswith("\nwall_e: SUCCESS\n")

    def test_a_tree_that_fails_prints_why_and_exits_with_1(self, simulator, capsys):
        simulator.session.robot = lambda goal: goal.abort(208, "no route")

        assert main(["run", GO, "--robot", "wall_e"]) == 1
        assert "GoToPoseAction [✕] -- aborted: no route" in capsys.readouterr().out

    def test_the_coverage_of_a_second_run_is_added_to_the_file(self, simulator, tmp_path):
        file = tmp_path / "seen.json"
        main(["run", GO, "--robot", "wall_e", "--coverage", str(file)])
        simulator.session.robot = lambda goal: goal.abort(208, "no route")
        main(["run", GO, "--robot", "wall_e", "--coverage", str(file)])

        keys = {key.rpartition("/")[2] for key in TreeCoverage.from_json(file.read_text(encoding="utf-8")).keys()}  # noqa: SIM118 - no mapping
        assert {"GoToPoseAction:SUCCESS", "GoToPoseAction:FAILURE", "208"} <= keys

    @pytest.mark.usefixtures("simulator")
    def test_a_file_without_coverage_is_not_overwritten(self, tmp_path, capsys):
        file = tmp_path / "seen.json"
        file.write_text("precious", encoding="utf-8")

        assert main(["run", GO, "--robot", "wall_e", "--coverage", str(file)]) == 2
        assert file.read_text(encoding="utf-8") == "precious"
        assert "seen.json: no coverage of trees: " in capsys.readouterr().err

    @pytest.mark.usefixtures("simulator")
    def test_a_robot_named_twice_is_run_once(self, capsys):
        assert main(["run", GO, "--robot", "wall_e", "eve", "--robot", "wall_e"]) == 0
        assert capsys.readouterr().out.endswith("\nwall_e: SUCCESS\neve: SUCCESS\n")

    def test_a_simulator_that_is_gone_is_named_with_a_remedy(self, simulator, capsys, monkeypatch):
        monkeypatch.setattr("bt_controller.cli.run._GRACE", 0.0)
        simulator.session.vanish()

        assert main(["run", "py_trees.behaviours:Running", "--robot", "wall_e"]) == 1
        error = "bt-controller: the simulator 'hmrsim' is gone; start it again, or look in its output for why it has"
        assert capsys.readouterr().err.startswith(error)

    @pytest.mark.usefixtures("simulator")
    def test_json_has_one_snapshot_a_line_and_then_the_outcome(self, capsys):
        main(["run", GO, "--robot", "wall_e", "--json"])

        *trees, end = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
        assert [tree["status"] for tree in trees] == ["SUCCESS", "SUCCESS"]
        assert end == {
            "succeeded": True,
            "interrupted": False,
            "gone": False,
            "robots": {"wall_e": "SUCCESS"},
            "left": [],
            "reasons": {},
        }

    @pytest.mark.usefixtures("simulator")
    def test_the_user_can_overrule_a_default_of_the_tree(self, capsys):
        main(["run", GO, "--robot", "wall_e", "--json", "--no-confirm"])

        assert len(capsys.readouterr().out.splitlines()) == 2

    @pytest.mark.usefixtures("simulator")
    def test_an_unknown_robot_lists_the_known_ones_and_exits_with_1(self, capsys):
        assert main(["run", GO, "--robot", "marvin"]) == 1
        assert capsys.readouterr().err == "bt-controller: no robot 'marvin'; there are eve, wall_e\n"

    @pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
    def test_a_signal_cancels_the_goal_and_is_the_exit_code(self, simulator, capsys, number, code):

        def then(goal):
            goal.when_canceled = goal.end_canceled
            os.kill(os.getpid(), number)

        simulator.session.robot = then

        assert main(["run", GO, "--robot", "wall_e"]) == code
        assert simulator.goals[0].canceled is True
        assert capsys.readouterr().err == "bt-controller: interrupted; the goals were canceled\n"

    def test_the_options_reach_the_session(self, simulator, monkeypatch):
        """Options take precedence over the environment, and the environment over defaults."""
        monkeypatch.setenv("HMRSIM_CONNECT", "tcp/a:1,tcp/b:2")
        monkeypatch.setenv("HMRSIM_PREFIX", "lab")
        main(["run", GO, "--robot", "wall_e", "--prefix", "mine", "--timeout", "2.5"])

        options = simulator.options
        assert (options.connect, options.prefix, options.timeout) == (("tcp/a:1", "tcp/b:2"), "mine", 2.5)

    @pytest.mark.parametrize(
        ("arguments", "part"),
        [([], ("auto", "bt_controller")), (["--clock", "lockstep", "--name", "ward_b"], ("lockstep", "ward_b"))],
    )
    def test_the_participant_name_is_an_option_and_the_same_in_every_run(self, simulator, arguments, part):
        main(["run", GO, "--robot", "wall_e", *arguments])

        assert simulator.part == part

    @pytest.mark.parametrize(
        ("variable", "value", "error"),
        [
            (
                "HMRSIM_TIMEOUT",
                "soon",
                "HMRSIM_TIMEOUT: 'soon' is not a valid time; expected a number of seconds greater than 0, up to 1e+09",
            ),
            ("HMRSIM_MODE", "peerless", "HMRSIM_MODE: no mode 'peerless'; did you mean 'peer'?"),
        ],
    )
    def test_a_bad_variable_is_named_and_exits_with_2(self, monkeypatch, capsys, variable, value, error):
        monkeypatch.setenv(variable, value)
        with pytest.raises(SystemExit, match="2"):
            main(["run", GO, "--robot", "wall_e"])

        assert capsys.readouterr().err == f"bt-controller: {error}\n"

    @pytest.mark.parametrize(
        ("arguments", "error"),
        [
            (["--robot", "wall-e"], "'wall-e' is not a robot's name; expected letters, digits and underscores"),
            (["--robot", "type:nurse"], "'type:nurse' is not a robot's name; selectors are for --robots"),
            (["--robot", "wall_e", "--period", "0"], "'0' is not a valid period"),
            (["--robot", "wall_e", "--name", "ward b"], "'ward b' is not a valid participant name"),
            (["--robot", "wall_e", "--clock", "wall"], "no clock 'wall'; there are auto, realtime, lockstep"),
            ([], "required: --robot"),
        ],
    )
    def test_wrong_usage_exits_with_2(self, capsys, arguments, error):
        with pytest.raises(SystemExit, match="2"):
            main(["run", GO, *arguments])

        assert error in capsys.readouterr().err

    def test_a_missing_simulator_is_one_line_and_exits_with_3(self, capsys):
        arguments = ["--connect", "tcp/127.0.0.1:1", "--timeout", "0.2"]

        assert main(["run", GO, "--robot", "wall_e", *arguments]) == 3
        assert capsys.readouterr().err.count("\n") == 1


class TestCheck:
    def test_a_good_tree_is_printed_without_a_simulator(self, capsys):
        code = main(["check", GO])

        assert code == 0
        assert capsys.readouterr().out == (
            "{-} GoToPoseSequence\n    {o} GoToPoseFallback\n        --> CheckArrived\n        --> GoToPoseAction\n"
        )

    def test_json_of_a_tree_has_the_classes_of_behaviors(self, capsys):
        main(["check", GO, "--json"])

        tree = json.loads(capsys.readouterr().out)
        assert tree["tree"] == GO
        assert tree["nodes"][2] == {
            "depth": 2,
            "symbol": "-->",
            "kind": "CheckBlackboardVariableValue",
            "name": "CheckArrived",
        }

    def test_a_bad_tree_is_one_line_and_exits_with_2(self, capsys):
        code = main(["check", "bt_controller.examples:go_to_pse"])

        out, err = capsys.readouterr()
        assert (code, out) == (2, "")
        assert err == (
            "bt-controller: bt_controller.examples:go_to_pse: module 'bt_controller.examples' has no 'go_to_pse';"
            " did you mean 'go_to_pose'?\n"
        )


def test_output_that_cannot_be_written_is_one_line():
    command = [sys.executable, "-m", "bt_controller", "check", GO]
    with Path("/dev/full").open("w", encoding="utf-8") as full:
        ended = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)

    assert ended.returncode == 1
    assert ended.stderr == "bt-controller: can't write the output: no space left on device\n"


def test_a_controller_loads_nothing_of_the_engine():
    """The controller is an outside client that could run on another machine."""
    program = (
        "import sys, bt_controller.cli, bt_controller.examples, bt_controller.running.runner\n"
        "engine = {'simpy', 'networkx', 'hmrsim.simulation.simulator', 'hmrsim.goals.dispatcher', "
        "'hmrsim.robots.robot'}\n"
        "print(sorted(engine & set(sys.modules)))"
    )
    found = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)

    assert found.stdout == "[]\n"


class TestRobots:
    def robots(self, capsys, *arguments):
        """Return exit code and robots of a run, or its errors."""
        code = main(["run", "bt_controller.examples:go_to_pose", *arguments, "--json"])
        out, err = capsys.readouterr()
        return code, list(json.loads(out.splitlines()[-1])["robots"]) if out else err

    @pytest.mark.usefixtures("simulator")
    def test_robots_are_selected_by_capability(self, capsys):
        assert (0, ["wall_e"]) == self.robots(capsys, "--robots", "action:pickup")

    @pytest.mark.usefixtures("simulator")
    def test_named_robots_come_before_selected_ones_and_none_twice(self, capsys):
        selected = self.robots(capsys, "--robots", "all", "action:pickup")
        named = self.robots(capsys, "--robots", "all", "--robot", "wall_e")

        assert ((0, ["eve", "wall_e"]), (0, ["wall_e", "eve"])) == (selected, named)

    @pytest.mark.usefixtures("simulator")
    def test_a_selector_without_a_match_exits_with_1(self, capsys):
        error = "bt-controller: no robot has action 'pick_up'; did you mean action:pickup?\n"

        assert (1, error) == self.robots(capsys, "--robots", "action:pick_up")

    def test_a_malformed_selector_is_reported_before_connecting(self, capsys):
        with pytest.raises(SystemExit, match="2"):
            main(["run", GO, "--robots", "carrier"])

        assert "argument --robots: 'carrier' selects no robots; expected all, type:NAME" in capsys.readouterr().err

    def test_no_robots_variable_is_read(self, monkeypatch, capsys):
        """A forgotten environment variable would drive the wrong robots."""
        monkeypatch.setenv("HMRSIM_ROBOTS", "all")
        with pytest.raises(SystemExit, match="2"):
            main(["run", GO])

        assert "required: --robot or --robots" in capsys.readouterr().err


def test_a_taken_participant_name_exits_with_2(capsys):
    with served_world(clock="lockstep") as options, Client(options, name="ward_b") as other:
        assert other.lockstep is not None
        code = main(["run", GO, "--robot", "wall_e", "--name", "ward_b", "--connect", options.connect[0]])

    error = "bt-controller: participant 'ward_b' has joined already; take another name\n"
    assert (2, error) == (code, capsys.readouterr().err)
