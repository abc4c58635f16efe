"""From a command line to an exit code."""

from __future__ import annotations

import subprocess
import sys
from types import SimpleNamespace

import pytest

from hmrsim import __version__
from hmrsim.cli import main
from hmrsim.cli.exits import ExitCode, UnknownName, WrongUse, code_of, text_of
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

COMMANDS = (
    ["run"],
    ["demo"],
    ["action"],
    ["action", "list"],
    ["action", "info"],
    ["action", "send-goal"],
    ["topic"],
    ["topic", "list"],
    ["topic", "echo"],
    ["topic", "hz"],
    ["service"],
    ["service", "list"],
    ["service", "call"],
    ["topic", "info"],
    ["topic", "type"],
    ["service", "type"],
    ["robot"],
    ["robot", "list"],
    ["fault"],
    ["fault", "inject"],
    ["fault", "list"],
    ["fault", "clear"],
    ["time"],
    ["time", "pause"],
    ["time", "step"],
    ["world"],
    ["world", "list"],
    ["world", "new"],
    ["world", "generate"],
    ["world", "schema"],
    ["doctor"],
    ["map"],
    ["map", "validate"],
    ["map", "info"],
    ["map", "plan"],
    ["map", "convert"],
    ["explain"],
    ["completion"],
)


@pytest.fixture
def broken_command(monkeypatch):
    """Return the function that makes ``hmrsim map`` raise an error."""

    def make(error):
        def fail(_args):
            raise error

        command = SimpleNamespace(configure=lambda parser: parser.set_defaults(function=fail))
        monkeypatch.setattr(command_line.importlib, "import_module", lambda _name: command)

    return make


def test_version(capsys):
    """``--version`` tells the version and succeeds."""
    code = main(["--version"])

    assert (0, f"hmrsim {__version__}\n") == (code, capsys.readouterr().out)


def test_help_names_every_command(capsys):
    """``--help`` lists the commands and the exit codes."""
    code = main(["--help"])

    out = capsys.readouterr().out
    assert 0 == code
    assert all(f"\n    {name} " in out for name in ("run", "simulate", "demo", "action", "topic", "service", "map"))
    assert "130  Ctrl-C" in out


@pytest.mark.parametrize("command", COMMANDS, ids=" ".join)
def test_every_command_has_examples(command, capsys):
    """The help of every command ends with examples."""
    code = main([*command, "--help"])

    assert 0 == code
    assert f"examples:\n  hmrsim {command[0]}" in capsys.readouterr().out


def test_help_loads_nothing_slow():
    """``hmrsim --help`` is quick because it loads neither Zenoh nor pydantic."""
    program = (
        "import sys; from hmrsim.cli import main; main(['--help']); "
        "slow = {'zenoh', 'pydantic', 'rich', 'yaml', 'argcomplete'}; print([*slow & {*sys.modules}], file=sys.stderr)"
    )

    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)

    assert "[]\n" == done.stderr


@pytest.mark.parametrize(
    "arguments",
    [
        [],
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
def test_wrong_use_is_2(arguments, capsys):
    """Errors of argparse end with 2 and one line on stderr."""
    code = main(arguments)

    captured = capsys.readouterr()
    assert (2, "") == (code, captured.out)
    assert "error: " in captured.err


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
    """An error's type decides the exit code."""
    assert code == code_of(error)


def test_errors_name_the_program():
    """Errors without a file begin with the name of the program."""
    assert "hmrsim: no simulator answers" == text_of(SimulatorNotFound("no simulator answers"))


def test_errors_of_files_begin_with_the_file():
    """Errors in a file begin with the file and line, as from a compiler."""
    assert "a.yaml:3: seed: no" == text_of(WorldError([Problem("a.yaml", "seed", "no", 3)]))


def test_a_known_error_is_one_line(broken_command, capsys):
    """A known error ends the command with its code and one line, no traceback."""
    broken_command(SimulatorNotFound("no simulator answers"))

    code = main(["map"])

    assert (ExitCode.NO_SIMULATOR, "hmrsim: no simulator answers\n") == (code, capsys.readouterr().err)


def test_interrupted(broken_command):
    """An unhandled Ctrl-C exits with 130."""
    broken_command(KeyboardInterrupt())

    assert 130 == main(["map"])


def test_every_line_of_an_error_names_the_program():
    """Each unknown name is a line."""
    assert "hmrsim: no a\nhmrsim: no b" == text_of(UnknownName("no a\nno b"))
