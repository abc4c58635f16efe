"""The settings of a run in programs and in files."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from hmrsim.errors import SettingsError
from hmrsim.settings.option import settings_of
from hmrsim.settings.run import DemoSettings, RunSettings, SimulateSettings, read_file
from hmrsim_zenoh.settings import SERVED


@pytest.mark.parametrize(
    ("fields", "why"),
    [
        ({"real_time_factor": -1.0}, "-1 is less than 0"),
        ({"real_time_factor": 1e7}, "1e[+]07 is greater than 1e[+]06; 0 is as fast as possible"),
        ({"real_time_factor": math.nan}, "'nan' is not a finite number"),
        ({"feedback_rate": 0.0}, "0 is not greater than 0"),
        ({"step_size": 5e-10}, "5e-10 s is less than a nanosecond"),
        ({"participants": 0}, "0 is not greater than 0"),
        ({"participants": ()}, "'' is neither a number nor names"),
        ({"participants": ("a nurse",)}, "'a nurse' is neither a number nor names"),
        ({"result_timeout": -2.0}, "-2 is less than 0; -1 is for ever"),
        ({"participant_timeout": 0.0}, "0 is not greater than 0"),
        ({"seed": 1.5}, "valid integer"),
        ({"seed": True}, "valid integer"),
        ({"keep_results": "10"}, "valid integer"),
        ({"clock": "sundial"}, "'realtime' or 'lockstep'"),
        ({"hold": 1.0}, "not permitted"),
    ],
)
def test_an_invalid_setting_is_rejected(fields, why):
    with pytest.raises(ValidationError, match=why):
        RunSettings(**fields)


def test_settings_are_immutable():
    with pytest.raises(ValidationError, match="frozen"):
        RunSettings().seed = 3


@pytest.mark.parametrize("name", ["participant_timeout", "planner_timeout"])
def test_minus_one_means_forever(name):
    assert math.inf == getattr(RunSettings(**{name: -1}), name) == getattr(RunSettings(**{name: math.inf}), name)


def test_names_of_participants_are_unique():
    assert ("nurses", "porters") == RunSettings(participants=["nurses", "porters", "nurses"]).participants


@pytest.mark.parametrize("model", [*SERVED, SimulateSettings, DemoSettings])
def test_every_setting_has_a_description_and_a_valid_default(model):
    for setting in settings_of(model).values():
        option = setting.option
        assert option.help
        assert not option.help.endswith(".")
        assert setting.default is None or setting.default == option.checked(setting.default)


def test_no_setting_is_in_two_models():
    """A settings file has one key for each setting."""
    names = [name for model in SERVED for name in settings_of(model)]

    assert sorted(set(names)) == sorted(names)


@given(st.floats())
def test_a_real_time_factor_is_valid_within_its_bounds(value):
    allowed = value == 0 or 1e-6 <= value <= 1e6
    try:
        factor = RunSettings(real_time_factor=value).real_time_factor
    except ValidationError:
        assert not allowed
    else:
        assert allowed
        assert value == factor


@pytest.fixture
def read(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def read(text):
        Path("s.yaml").write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_file(Path("s.yaml"), SERVED)

    return read


def test_a_file_can_have_settings_of_all_kinds(read):
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


def test_json_is_read(read):
    assert {"seed": 3, "duration": 10.0} == read(json.dumps({"seed": 3, "duration": 10}, indent="\t"))


def test_a_file_of_comments_is_an_error(read):
    """The user probably meant to set something."""
    with pytest.raises(SettingsError, match=r"s\.yaml: is empty"):
        read("# nothing\n")


@pytest.mark.parametrize(
    ("text", "message"),
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
def test_an_error_is_reported_with_its_line(read, text, message):
    with pytest.raises(SettingsError) as error:
        read(text)

    assert str(error.value).startswith(message)


def test_all_errors_are_reported_at_once(read):
    with pytest.raises(SettingsError) as error:
        read("seed: x\nclok: lockstep\nclock: sundial\nseed: 3\n")

    assert [(1, "seed"), (2, "clok"), (3, "clock"), (4, "seed")] == [
        (problem.line, problem.path) for problem in error.value.problems
    ]


@pytest.mark.parametrize(
    ("path", "message"), [("none.yaml", "none.yaml: no such file"), (".", ".: is a folder; expected a file")]
)
def test_an_unreadable_file_is_an_error(tmp_path, monkeypatch, path, message):
    monkeypatch.chdir(tmp_path)

    with pytest.raises(SettingsError, match=message):
        read_file(Path(path), SERVED)


def test_a_huge_file_is_rejected(read):
    with pytest.raises(SettingsError, match="is larger than 16 MiB"):
        read(b"#" * (16 * 1024 * 1024 + 1))
