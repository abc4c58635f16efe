"""Commands in this process."""

from __future__ import annotations

import pytest

from hmrsim.cli import main


@pytest.fixture
def hmrsim(capsys):
    """Return the function that runs a command and returns exit code, output and errors.

    The first argument is the command with its first words, which are separated by spaces.
    """

    def run(command, *words):
        code = main([*command.split(), *map(str, words)])
        return code, *capsys.readouterr()

    return run
