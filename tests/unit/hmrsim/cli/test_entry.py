"""From a command line to an exit code."""

from __future__ import annotations

import subprocess
import sys
from types import SimpleNamespace

import pytest

import bt_controller.cli
from hmrsim import __version__
from hmrsim.cli import main, make_parser
from hmrsim.cli.options import ExitCode, UnknownName, WrongUse, code_of, text_of
from hmrsim.errors import HmrsimError, Problem, WorldError
from hmrsim.program import command_line
from hmrsim_zenoh.errors import (
    BadOptions,
    GoalRejectedError,
    PortTaken,
    PrefixTaken,
    RequestTimeout,
    SimulatorGone,
    SimulatorNotFound,
    Unreachable,
)
from tests.cases import case
from tests.parsers import parsers_of


@pytest.fixture
def broken_command(monkeypatch):
    def make(error):
        def fail(_args):
            raise error

        command = SimpleNamespace(configure=lambda parser: parser.set_defaults(function=fail))
        monkeypatch.setattr(command_line.importlib, "import_module", lambda _name: command)

    return make


def test_version_is_printed(capsys):
    code = main(["--version"])

    assert (0, f"hmrsim {__version__}\n") == (code, capsys.readouterr().out)


@pytest.mark.parametrize("words", [[], ["help"], ["--help"]], ids=" ".join)
def test_help_lists_the_commands_by_purpose(words, capsys):
    """The program alone and its word ``help`` print the same as ``--help``."""
    code = main(words)

    out = capsys.readouterr().out
    assert 0 == code
    assert out.index("\n    drive robots:\n") < out.index("\n      action ") < out.index("\n    make worlds:\n")
    assert "130  Ctrl-C" in out


def test_help_of_a_command_is_that_of_its_option(capsys):
    """``hmrsim help topic echo`` prints what ``hmrsim topic echo --help`` prints."""
    main(["help", "topic", "echo"])
    asked = capsys.readouterr().out

    main(["topic", "echo", "--help"])

    assert capsys.readouterr().out == asked


def test_every_command_has_examples():
    for program in (make_parser(), bt_controller.cli.make_parser()):
        for parser in parsers_of(program):
            with case(parser.prog):
                assert f"examples:\n  {program.prog} " in parser.format_help()


def test_help_imports_neither_zenoh_nor_pydantic():
    program = (
        "import sys; from hmrsim.cli import main; main(['--help']); "
        "slow = {'zenoh', 'pydantic', 'rich', 'yaml', 'argcomplete'}; print([*slow & {*sys.modules}], file=sys.stderr)"
    )

    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)

    assert "[]\n" == done.stderr


@pytest.mark.parametrize(
    "arguments",
    [
        ["frobnicate"],
        ["run"],
        ["run", "scenario1", "--real-time-factor", "-1"],
        ["run", "scenario1", "--duration", "0"],
        ["run", "scenario1", "--keep-results", "1.5"],
        ["run", "scenario1", "--feedback-rate", "nan"],
        ["action", "send-goal", "/wall_e/wait", "nav2_msgs/action/Wait", "{}", "{}"],
        ["map", "validate", "hospital", "--jso"],
        ["map", "plan", "hospital", "lab"],
        ["map", "plan", "hospital", "lab", "pharmacy", "--speed", "1", "--for", "eve"],
        ["completion", "tcsh"],
        ["topic", "list", "--connect", "nowhere"],
        ["topic", "list", "--log-level", "loud"],
    ],
    ids=" ".join,
)
def test_wrong_use_exits_with_2_and_one_line(arguments, capsys):
    code = main(arguments)

    captured = capsys.readouterr()
    assert (2, "") == (code, captured.out)
    assert captured.err.startswith("hmrsim: ")
    assert 1 == captured.err.count("\n")


def test_an_option_of_other_servers_leads_to_ours(capsys):
    """Many programs call the port to serve at --port."""
    main(["run", "cafe", "--port", "1"])

    assert "; did you mean --listen tcp/127.0.0.1:PORT, or --view PORT for the page?\n" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (HmrsimError("x"), 1),
        (UnknownName("x"), 1),
        (GoalRejectedError("busy", 1, "x"), 1),
        (WrongUse("x"), 2),
        (WorldError([Problem("a.yaml", "", "is empty")]), 2),
        (BadOptions("x"), 2),
        (PortTaken("x"), 2),
        (PrefixTaken("x"), 2),
        (SimulatorNotFound("x"), 3),
        (SimulatorGone("x"), 3),
        (RequestTimeout("x"), 3),
        (Unreachable("x"), 3),
    ],
    ids=lambda value: type(value).__name__,
)
def test_each_error_has_its_exit_code(error, code):
    assert code == code_of(error)


@pytest.mark.parametrize(
    ("error", "text"),
    [
        (SimulatorNotFound("no simulator answers"), "hmrsim: no simulator answers"),
        (UnknownName("no a\nno b"), "hmrsim: no a\nhmrsim: no b"),
        (WorldError([Problem("a.yaml", "seed", "no", 3)]), "a.yaml:3: seed: no"),
    ],
)
def test_each_line_of_an_error_begins_with_the_program_or_the_file(error, text):
    assert text == text_of(error)


def test_a_known_error_is_one_line(broken_command, capsys):
    broken_command(SimulatorNotFound("no simulator answers"))

    code = main(["map"])

    assert (ExitCode.NO_SIMULATOR, "hmrsim: no simulator answers\n") == (code, capsys.readouterr().err)


def test_ctrl_c_exits_with_130(broken_command):
    broken_command(KeyboardInterrupt())

    assert 130 == main(["map"])


WALL_SECONDS = ["--participant-timeout", "--planner-timeout", "--result-timeout", "--timeout"]
RATES = ["--feedback-rate", "--odom-rate", "--clock-rate", "--detection-rate", "--battery-rate"]
OPTIONS = [
    *(f"run scenario1 {option}" for option in (*WALL_SECONDS, *RATES, "--step-size", "--keep-results")),
    "run scenario1 --max-payload",
    "run scenario1 --real-time-factor",
    "simulate scenario1 --seed",
    "action list --timeout",
    "topic hz /wall_e/odom --window",
    "record run.mcap --duration",
    "view --port",
    "map render scenario1 --width",
    "map render scenario1 --scale",
    "map plan scenario1 a b --speed",
    "demo --real-time-factor",
]


@pytest.mark.parametrize("option", OPTIONS)
def test_unusable_numbers_are_wrong_use(option, capsys):
    for text in ("1e308", "nan", "inf", "-inf", "1" + "0" * 5_000, "x", "", "\x1b[2J"):
        code = main([*option.split(), text])
        output = capsys.readouterr()

        assert (2, 1, "") == (code, output.err.count("\n"), output.out), (text, output.err)
        assert "\x1b" not in output.err
