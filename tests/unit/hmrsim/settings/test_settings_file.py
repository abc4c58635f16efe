"""Settings files: what they may say, and what is told of mistakes."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from hmrsim.errors import SettingsError
from hmrsim.settings.file import read_file
from hmrsim_zenoh.settings import SERVED


@pytest.fixture
def read(tmp_path, monkeypatch):
    """Return a function that reads a text as a settings file."""
    monkeypatch.chdir(tmp_path)

    def read(text):
        Path("s.yaml").write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_file(Path("s.yaml"), SERVED)

    return read


def test_all_kinds_of_settings(read):
    """A settings file can have numbers, names, lists, paths and flags."""
    text = """\
clock: lockstep
participants: [a, b]
planner_timeout: -1
listen: ["tcp/[::]:0"]
trace: t.jsonl
ros2: true
"""

    assert {
        "clock": "lockstep",
        "participants": ("a", "b"),
        "planner_timeout": math.inf,
        "listen": ("tcp/[::]:0",),
        "trace": Path("t.jsonl"),
        "ros2": True,
    } == read(text)


def test_json_is_read_too(read):
    """A settings file can be JSON."""
    assert {"seed": 3, "duration": 10.0} == read(json.dumps({"seed": 3, "duration": 10}, indent="\t"))


def test_a_file_of_comments_is_an_error(read):
    """A file without settings is an error, as it was probably meant to have some."""
    with pytest.raises(SettingsError, match=r"s\.yaml: is empty"):
        read("# nothing\n")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("seed: x", "s.yaml:1: seed: expected a whole number, got 'x'"),
        ("seed: 1.5", "s.yaml:1: seed: expected a whole number, got 1.5"),
        ("seed: 1\nseed: 2", "s.yaml:2: seed: key 'seed' is there twice, first in line 1; keep one"),
        ("\nclok: lockstep", "s.yaml:2: clok: unknown key 'clok'; did you mean 'clock'?"),
        ("clock: sundial", "s.yaml:1: clock: expected 'realtime' or 'lockstep', got 'sundial'"),
        ("duration: .nan", "s.yaml:1: duration: 'nan' is not a finite number"),
        ("duration: -1", "s.yaml:1: duration: -1 is not greater than 0"),
        ("ros2: yes", "s.yaml:1: ros2: expected true or false, got 'yes'"),
        ("view: 70000", "s.yaml:1: view: 70000 is greater than 65535"),
        ("connect: [here]", "s.yaml:1: connect: 'here' is not an endpoint; expected PROTOCOL/ADDRESS"),
        ("connect: tcp/127.0.0.1:7447", "s.yaml:1: connect: expected a list, got 'tcp/127.0.0.1:7447'"),
        ("prefix: a//b", "s.yaml:1: prefix: "),
        ("participants: {a: 1}", "s.yaml:1: participants: "),
        ("trace: 3", "s.yaml:1: trace: expected a path, got 3"),
        ("page: 2", "s.yaml:1: page: expected text, got 2; put it in quotes"),
        ("- seed", "s.yaml:1: expected a mapping with settings such as clock: lockstep, got ['seed']"),
        ("seed", "s.yaml:1: expected a mapping with settings such as clock: lockstep, got 'seed'"),
        ("seed: [", "s.yaml:2: is not valid YAML"),
        ("a: &a [*a]", "s.yaml:1: alias 'a' is inside what it stands for"),
        ("seed: 1\n---\nseed: 2", "s.yaml:2: has more than one document; keep one"),
        (b"seed: \xff", "s.yaml:1: is not UTF-8"),
    ],
)
def test_an_error_is_reported_with_its_line(read, text, told):
    """An error has the line, the setting, its value and a remedy."""
    with pytest.raises(SettingsError) as error:
        read(text)

    assert str(error.value).startswith(told)


def test_all_errors_are_reported_at_once(read):
    """All errors are reported at once, in the order of the file."""
    with pytest.raises(SettingsError) as error:
        read("seed: x\nclok: lockstep\nclock: sundial\nseed: 3\n")

    assert [(1, "seed"), (2, "clok"), (3, "clock"), (4, "seed")] == [
        (problem.line, problem.path) for problem in error.value.problems
    ]


@pytest.mark.parametrize(
    ("path", "told"), [("none.yaml", "none.yaml: no such file"), (".", ".: is a folder; expected a file")]
)
def test_a_file_that_is_none(tmp_path, monkeypatch, path, told):
    """A file that can't be read is an error."""
    monkeypatch.chdir(tmp_path)

    with pytest.raises(SettingsError, match=told):
        read_file(Path(path), SERVED)


def test_a_huge_file_is_rejected(read):
    """A huge file is rejected before it is parsed."""
    with pytest.raises(SettingsError, match="is larger than 16 MiB"):
        read(b"#" * (16 * 1024 * 1024 + 1))
