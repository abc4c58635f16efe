"""Explanations of error codes, reasons, causes and exit codes."""

from __future__ import annotations

import pytest

from hmrsim.actions import registry
from hmrsim.cli import main
from hmrsim.cli.options import ExitCode
from hmrsim.explanations import explanations
from hmrsim.faults import registry as faults
from hmrsim.interfaces.moveit_msgs import MoveItErrorCodes
from hmrsim.protocol.goal import Cause

REASONS = {
    "invalid_goal_id",
    "duplicate_goal_id",
    "unknown_robot",
    "unknown_action",
    "invalid_goal",
    "not_ready",
    "busy",
    "internal_error",
}
"""As docs/reference/keys.md lists them."""
OURS_OF_MOVEIT = {-1, -3, -4, -7, -17, -19, 99999}
NO_ERRORS = {"NONE", "ALL_GOALS"}


def codes_of_results():
    found = {}
    for action in registry().values():
        for kind in action.result.__mro__:
            for name, value in vars(kind).items():
                if name.isupper() and type(value) is int and name not in NO_ERRORS and not name.startswith("RESULT_"):
                    found[str(value)] = name
    return found


def test_every_code_of_a_result_is_explained_under_its_name():
    known = explanations()
    moveit = {
        str(value): name
        for name, value in vars(MoveItErrorCodes).items()
        if type(value) is int and value in OURS_OF_MOVEIT
    }

    for code, name in {**codes_of_results(), **moveit}.items():
        assert known[code].name == name, code


def test_exactly_the_possible_codes_are_explained():
    exits = {f"exit_{code.value}" for code in ExitCode if code} | {"exit_143"}
    codes = {*codes_of_results(), *map(str, OURS_OF_MOVEIT)}
    causes = {cause.value for cause in Cause if cause.value} | {name for name in faults() if name in explanations()}
    services = {f"result_{value}" for value in (0, 2, 3, 4)}

    assert set(explanations()) == codes | REASONS | causes | services | exits


@pytest.mark.parametrize("code", ["208", "-19", "not_ready", "exit_3"])
def test_the_command_prints_an_explanation(code, capsys):
    assert 0 == main(["explain", code])

    out = capsys.readouterr().out
    assert out.startswith(f"{code} ")
    assert "\nWhy:\n" in out
    assert "\nWhat to do:\n" in out


def test_the_command_lists_all_codes(capsys):
    assert 0 == main(["explain", "--codes"])

    assert [*explanations()] == [line.split()[0] for line in capsys.readouterr().out.splitlines()]


def test_without_a_simulator_the_command_lists_all_codes(capsys):
    assert 0 == main(["explain", "--connect", "tcp/127.0.0.1:1", "--timeout", "0.1"])

    out, errors = capsys.readouterr()
    assert len(explanations()) == len(out.splitlines())
    assert "all codes:" in errors


def test_a_code_and_the_list_of_codes_are_not_combined(capsys):
    assert 2 == main(["explain", "208", "--codes"])
    assert "give only one of a code, --robot and --codes" in capsys.readouterr().err


def test_lists_keep_their_lines(capsys):
    main(["explain", "104"])

    lines = capsys.readouterr().out.splitlines()
    first = next(i for i, line in enumerate(lines) if line.startswith("  - idle: the robot has no goal. "))
    assert "" == lines[first - 1]
    assert lines[first + 1].startswith("    ")


def test_advice_names_the_policies_that_it_is_for():
    """The command knows no world."""
    advice = explanations()["104"].do

    sentences = [sentence for sentence in advice.replace("\n", " ").split(". ") if "policy `planned`" in sentence]
    assert 1 == len(sentences)
    assert sentences[0].startswith("Under `reserve`")


CAUSES = ("idle", "a circle", "a goal such as `pickup` or `wait`", "docked or charging", "out of service")


@pytest.mark.parametrize("cause", CAUSES)
def test_each_last_cause_has_advice(cause):
    assert f"\n- {cause}: " in explanations()["104"].do


@pytest.mark.parametrize(
    ("code", "message"),
    [
        ("not_redy", "no code 'not_redy'; did you mean 'not_ready'?; `hmrsim explain --codes` lists all"),
        (
            "3001",
            "no code '3001'; `hmrsim action info` lists those of an action of a package; `hmrsim explain --codes`",
        ),
    ],
)
def test_a_code_that_is_none(capsys, code, message):
    assert main(["explain", code]) != 0
    assert message in capsys.readouterr().err
