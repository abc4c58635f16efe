"""Checks that commands import their dependencies late."""

from __future__ import annotations

import subprocess
import sys
from functools import partial

import pytest

import bt_controller.cli
import hmrsim.cli
from hmrsim.program.command_line import Later
from tests.parsers import parsers_of

HELP_OF_ALL = """
import contextlib, io, sys
from {package} import _COMMANDS, main
with contextlib.redirect_stdout(io.StringIO()):
    for command in ([], *([name] for name in _COMMANDS)):
        with contextlib.suppress(SystemExit):
            main([*command, "--help"])
print(sorted({heavy} & {{*sys.modules}}))
"""


@pytest.mark.parametrize(
    ("package", "heavy"),
    [
        ("hmrsim.cli", {"mcap", "networkx", "py_trees", "rich", "simpy", "starlette"}),
        ("bt_controller.cli", {"networkx", "py_trees", "pydantic", "rich", "simpy", "yaml", "zenoh"}),
    ],
)
def test_help_imports_no_dependency_of_a_command(package, heavy):
    program = HELP_OF_ALL.format(package=package, heavy=heavy)
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)

    assert "[]\n" == done.stdout


@pytest.mark.parametrize("module", ["robot", "explain", "action", "service", "topic", "doctor"])
def test_commands_for_a_running_simulator_import_no_simulation(module):
    program = f"import hmrsim.cli.{module}, sys; print('simpy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)

    assert "False\n" == done.stdout


@pytest.mark.parametrize("program", [hmrsim.cli, bt_controller.cli], ids=lambda module: module.__name__)
def test_late_imports_exist(program):
    values = []
    for parser in parsers_of(program.make_parser()):
        values += parser._defaults.values()
        for action in parser._actions:
            values += action.type.args if isinstance(action.type, partial) else [action.type]
    later = [value for value in values if isinstance(value, Later)]

    assert len(later) > 1
    assert all(callable(found.loaded()) for found in later)
