"""What is no file to read is one line and exit 2, for each command that reads one; none of them waits."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest

import bt_controller.cli
from hmrsim.cli import main

COMMANDS = [
    "hmrsim simulate {}",
    "hmrsim run {}",
    "hmrsim run scenario1 --settings {}",
    "hmrsim run scenario1 --zenoh-config {}",
    "hmrsim replay {}",
    "hmrsim report {}",
    "hmrsim view {}",
    "hmrsim map info {}",
    "hmrsim map convert {} out.yaml",
    "hmrsim map render {} -o out.svg",
    "bt-controller check {}",
    "bt-controller check {}.xml",
]

PROGRAMS = {"hmrsim": main, "bt-controller": bt_controller.cli.main}


def _pipe() -> str:
    os.mkfifo("pipe")
    os.mkfifo("pipe.xml")
    return "pipe"


def _folder() -> str:
    Path("folder").mkdir()
    Path("folder.xml").mkdir()
    return "folder"


def _device() -> str:
    Path("device").symlink_to("/dev/zero")
    Path("device.xml").symlink_to("/dev/zero")
    return "device"


def _round() -> str:
    Path("round").symlink_to("round")
    Path("round.xml").symlink_to("round.xml")
    return "round"


@pytest.mark.parametrize("make", [_pipe, _folder, _device, _round, lambda: "none", lambda: "x" * 5000])
def test_what_is_no_file(tmp_path, monkeypatch, capsys, make: Callable[[], str]):
    """A pipe that is never written, a folder, a device, a link to itself, nothing, and a name that is too long."""
    monkeypatch.chdir(tmp_path)
    name = make()
    for command in COMMANDS:
        program, *arguments = command.format(name).split()
        code = PROGRAMS[program](arguments)
        told = capsys.readouterr()

        assert (2, 1, "") == (code, told.err.count("\n"), told.out), (command, told.err)
        assert "Traceback" not in told.err


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ('{"a":' * 100_000 + "1" + "}" * 100_000, "nested deeper than 50"),
        ('{"mode": "' + "x" * 2_000_000 + '"}', "larger than 1048576 bytes"),
    ],
)
def test_a_zenoh_configuration_that_is_too_much_for_zenoh(tmp_path, capsys, text, why):
    """Its parser would end the process, or take long."""
    file = tmp_path / "zenoh.json5"
    file.write_text(text)

    assert 2 == main(["topic", "list", "--zenoh-config", str(file)])
    assert f"hmrsim: {file}: not a Zenoh configuration: {why}\n" == capsys.readouterr().err
