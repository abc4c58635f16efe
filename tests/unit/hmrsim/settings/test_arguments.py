"""Settings from the command line, the environment and a file."""

from __future__ import annotations

import math

import pytest

from hmrsim.cli import main
from hmrsim.program.command_line import CommandParser
from hmrsim.settings.arguments import add_settings, read_settings
from hmrsim.settings.run import RunSettings
from tools.settings import strangers


@pytest.fixture
def read():
    def read(*words, below=None):
        parser = CommandParser(prog="hmrsim run")
        add_settings(parser, RunSettings)
        return read_settings(parser.parse_args(words), RunSettings, below)

    return read


def test_an_empty_command_line_has_the_defaults(read):
    assert RunSettings() == read()


def test_sources_have_a_precedence(read, monkeypatch):
    monkeypatch.setenv("HMRSIM_SEED", "2")
    monkeypatch.setenv("HMRSIM_STEP_SIZE", "0.2")
    settings = read("--seed", "1", below={"seed": 3, "step_size": 0.3, "duration": 30.0})

    assert (1, 0.2, 30.0, 1.0) == (settings.seed, settings.step_size, settings.duration, settings.real_time_factor)


@pytest.mark.parametrize(
    ("words", "field", "value"),
    [
        (("--participants", "2"), "participants", 2),
        (("--participants", "b,a,b"), "participants", ("b", "a")),
        (("--participant-timeout", "-1"), "participant_timeout", math.inf),
        (("--result-timeout", "-1"), "result_timeout", -1.0),
        (("--on-participant-loss", "end"), "on_participant_loss", "end"),
    ],
)
def test_an_argument_is_converted_to_its_type(read, words, field, value):
    assert value == getattr(read(*words), field)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--seed", "x"), "argument --seed: 'x' is not a whole number"),
        (("--duration", "inf"), "argument --duration: 'inf' is not a finite number"),
        (("--duration", "0"), "argument --duration: 0 is not greater than 0"),
        (("--keep-results", "0"), "argument --keep-results: '0' is not a whole number greater than 0"),
        (("--result-timeout", "-2"), "argument --result-timeout: -2 is less than 0; -1 is for ever"),
        (("--real-time-factor", "1e7"), "1e7 is greater than 1e+06; 0 is as fast as possible"),
        (("--step-size", "1e-10"), "1e-10 s is less than a nanosecond"),
        (("--clock", "sundial"), "no clock 'sundial'; there are realtime, lockstep"),
        (("--participants", "a b"), "'a b' is neither a number nor names such as nurses,porters"),
    ],
)
def test_an_invalid_argument_is_wrong_use(read, capsys, words, message):
    with pytest.raises(SystemExit, match="2"):
        read(*words)

    assert message in capsys.readouterr().err


def test_lint_finds_options_that_no_model_declares():
    def configure(parser):
        add_settings(parser, RunSettings, only=("seed",))
        parser.add_argument("--json", action="store_true")
        parser.add_argument("--warp", type=float)
        parser.add_argument("--clock", default="realtime")

    assert ["hmrsim x --warp: is not a setting", "hmrsim x --clock: differs from its setting"] == [
        problem.partition(";")[0] for problem in strangers("x", configure, (RunSettings,))
    ]


def test_an_invalid_settings_file_is_wrong_use(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "s.yaml").write_text("seed: x\nlisten: [nowhere]\n")

    assert 2 == main(["run", "scenario1", "--settings", "s.yaml"])
    assert [
        "s.yaml:1: seed: expected a whole number, got 'x'",
        "s.yaml:2: listen: 'nowhere' is not an endpoint; expected PROTOCOL/ADDRESS, such as tcp/127.0.0.1:7447",
    ] == capsys.readouterr().err.splitlines()


def test_conflicting_settings_of_a_file_are_reported(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "s.yaml").write_text("ros_domain_id: 3\n")

    assert 2 == main(["run", "scenario1", "--settings", "s.yaml"])
    assert "hmrsim: --ros-domain-id is for --ros2; add that\n" == capsys.readouterr().err


def test_problems_of_a_settings_file_are_limited(tmp_path, capsys):
    path = tmp_path / "settings.yaml"
    path.write_text("seed: 1\n" * 3_000)
    code = main(["run", "scenario1", "--settings", str(path)])
    lines = capsys.readouterr().err.splitlines()

    assert (2, 1_001, f"{path}: and 1999 more") == (code, len(lines), lines[-1])
