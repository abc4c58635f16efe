"""bt-controller check and run, given files."""

from __future__ import annotations

import json

import pytest
from py_trees.common import Status

from bt_controller.cli import main
from bt_controller.cli._options import _value, exit_code
from bt_controller.cli.run import _report
from bt_controller.core.node import PortError
from bt_controller.running.runner import Outcome
from tests.paths import TESTS

FIXTURES = TESTS / "unit" / "bt_controller" / "loading" / "data"

NAVIGATE = """\
<root BTCPP_format="4" main_tree_to_execute="Go">
  <BehaviorTree ID="Go">
    <RecoveryNode number_of_retries="2" name="Drive">
      <NavigateToPose goal="{goal}"/>
      <Sleep msec="1000"/>
    </RecoveryNode>
  </BehaviorTree>
  <BehaviorTree ID="Stay"><Sleep msec="5" name="Rest"/></BehaviorTree>
</root>
"""
UNSET = "bt-controller: tree.xml:4: <NavigateToPose>: nothing writes 'goal'; give it with --set goal=…\n"


@pytest.fixture(autouse=True)
def tree(files):
    files.write(NAVIGATE)


class TestCheck:
    """The command bt-controller check prints a tree or its errors."""

    def test_a_good_file_is_printed(self, capsys):
        assert main(["check", "tree.xml"]) == 0
        out, err = capsys.readouterr()
        assert ("{*} Drive\n    --> NavigateToPose\n    --> Sleep\n", UNSET) == (out, err)

    def test_a_tree_for_several_robots_is_built_for_those_that_are_named(self, files, capsys):
        text = "from py_trees.behaviours import Success\n\ndef pair(robots):\n    return Success(robots[0] + robots[1])"
        (files.folder / "pair.py").write_text(text)

        assert main(["check", "pair.py:pair", "--robot", "eve", "mo"]) == 0
        assert "--> evemo" in capsys.readouterr().out
        assert main(["check", "pair.py:pair"]) == 2
        assert "it was given one robot, others are named by --robot" in capsys.readouterr().err

    def test_given_entries_are_not_listed(self, capsys):
        assert main(["check", "tree.xml", "--set", "goal=kitchen"]) == 0
        assert capsys.readouterr().err == ""

    def test_a_tree_as_nav2_has_it_is_right(self, capsys):
        path = FIXTURES / "drive_and_recover.xml"

        assert main(["check", str(path)]) == 0
        assert capsys.readouterr().err == (
            f"bt-controller: {path}:42: <ComputePathToPose>: nothing writes 'goal'; give it with --set goal=…\n"
        )

    def test_a_doubt_is_printed_and_no_error(self, files, capsys):
        files.write(NAVIGATE.replace(' BTCPP_format="4"', ""))

        assert main(["check", "tree.xml", "--set", "goal=kitchen", "--set", "gaol=x"]) == 0
        first, second = capsys.readouterr().err.splitlines()
        assert first.startswith("bt-controller: warning: tree.xml:1: <root>: has no BTCPP_format; ")
        assert second == "bt-controller: warning: nothing reads 'gaol'; did you mean 'goal'?"

    def test_an_empty_module_is_wrong_use(self, capsys):
        assert main(["check", "tree.xml", "--nodes", ""]) == 2
        assert capsys.readouterr().err == "bt-controller: --nodes: '' is not a module name\n"

    def test_the_tree_can_be_chosen(self, capsys):
        assert main(["check", "tree.xml", "--tree", "Stay"]) == 0
        assert capsys.readouterr().out == "--> Rest\n"

    def test_a_file_as_json(self, capsys):
        main(["check", "tree.xml", "--json"])

        assert [node["name"] for node in json.loads(capsys.readouterr().out)["nodes"]] == [
            "Drive",
            "NavigateToPose",
            "Sleep",
        ]

    def test_each_error_is_a_line(self, files, capsys):
        files.write(NAVIGATE.replace('msec="1000"', 'sec="1"').replace("NavigateToPose", "NavigateToPos"))

        assert main(["check", "tree.xml"]) == 2
        out, err = capsys.readouterr()
        assert out == ""
        assert err.splitlines()[0] == (
            "bt-controller: tree.xml:4: <NavigateToPos>: unknown node; did you mean 'NavigateToPose'?"
        )
        assert err.splitlines()[1].startswith("bt-controller: tree.xml:5: <Sleep>: unknown port 'sec'; ")

    def test_a_goal_for_another_robot_is_addressed_by_its_server(self, files, capsys):
        files.write(NAVIGATE.replace("<NavigateToPose ", '<NavigateToPose robot="bob" '))

        assert main(["check", "tree.xml"]) == 2
        assert capsys.readouterr().err.endswith(
            "<NavigateToPose>: unknown port 'robot'; to send the goal to another robot, write "
            'server_name="bob/navigate_to_pose"\n'
        )

    def test_a_file_needs_no_ending(self, files, capsys):
        files.write(NAVIGATE, "tree.bt")

        assert main(["check", "tree.bt", "--tree", "Stay"]) == 0
        assert capsys.readouterr().out == "--> Rest\n"

    def test_options_for_files_are_for_files(self, capsys):
        assert main(["check", "bt_controller.examples:go_to_pose", "--tree", "x"]) == 2
        assert capsys.readouterr().err == (
            "bt-controller: bt_controller.examples:go_to_pose is not an XML file;"
            " --tree and --nodes apply to XML files only\n"
        )

    @pytest.mark.parametrize("text", ["goal", "=x", "a b=x", "/a=x", "a.b=x"])
    def test_a_malformed_value_is_wrong_use(self, text, capsys):
        with pytest.raises(SystemExit, match="2"):
            main(["check", "tree.xml", "--set", text])

        assert f"{text!r} is not KEY=VALUE, such as goal=kitchen" in capsys.readouterr().err

    def test_a_value_may_have_any_letters(self):
        assert _value("sub/goal=9;2=4 ") == ("sub/goal", "9;2=4 ")


class TestRun:
    """The command bt-controller run runs a tree."""

    def test_nothing_begins_while_something_is_missing(self, capsys):
        assert main(["run", "tree.xml", "--robot", "wall_e"]) == 2
        assert capsys.readouterr().err == UNSET

    def test_a_given_value_that_no_port_takes_is_wrong_use(self, capsys):
        assert main(["run", "tree.xml", "--robot", "wall_e", "--set", "goal=1;2;3;4"]) == 2
        assert capsys.readouterr().err.startswith(
            "bt-controller: tree.xml:4: <NavigateToPose>: port 'goal': --set goal=1;2;3;4: '1;2;3;4' is not a pose; "
        )

    def test_a_skipped_tree_is_reported_as_skipped(self, capsys):
        """Its py_trees status has no meaning for a user."""
        _report(Outcome({"wall_e": Status.INVALID}), "hmrsim", as_json=False)

        assert capsys.readouterr().out == "wall_e: skipped\n"

    def test_a_value_that_is_found_wrong_at_setup_is_wrong_use(self):
        """Such as the name of a place, of which only the simulator knows."""
        assert exit_code(PortError("no place 'nowhere'")) == 2
