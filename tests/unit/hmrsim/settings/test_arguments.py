"""Settings on the command line, in the environment and in a file: what comes first, and what is told of mistakes."""

from __future__ import annotations

import math

import pytest

from hmrsim.cli import main
from hmrsim.program.command_line import CommandParser
from hmrsim.settings.arguments import add_settings, given, read_settings
from hmrsim.settings.run import RunSettings
from tools.settings import strangers


@pytest.fixture
def read():
    """Return a function that reads a command line."""

    def read(*words, below=None):
        parser = CommandParser(prog="hmrsim run")
        add_settings(parser, RunSettings)
        return read_settings(parser.parse_args(words), RunSettings, below)

    return read


def test_without_any_word_all_is_as_a_program_has_it(read):
    """An empty command line has the same defaults as a program."""
    assert RunSettings() == read()


def test_the_command_line_comes_before_the_environment_before_the_file_before_the_default(read, monkeypatch):
    """Each source provides the settings that the earlier ones leave open."""
    monkeypatch.setenv("HMRSIM_SEED", "2")
    monkeypatch.setenv("HMRSIM_STEP_SIZE", "0.2")
    settings = read("--seed", "1", below={"seed": 3, "step_size": 0.3, "duration": 30.0})

    assert (1, 0.2, 30.0, 1.0) == (settings.seed, settings.step_size, settings.duration, settings.real_time_factor)


def test_only_what_was_given_is_given():
    """Only given settings are returned, so that a file can provide the others."""
    parser = CommandParser()
    add_settings(parser, RunSettings)

    assert {"seed": 0} == given(parser.parse_args(["--seed", "0"]), RunSettings)


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
def test_a_word_is_read_as_its_setting(read, words, field, value):
    """An argument is converted to the type of its setting."""
    assert value == getattr(read(*words), field)


@pytest.mark.parametrize(
    ("words", "told"),
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
def test_an_invalid_word_is_wrong_use(read, capsys, words, told):
    """An invalid argument is reported in one line."""
    with pytest.raises(SystemExit, match="2"):
        read(*words)

    assert told in capsys.readouterr().err


def test_an_option_of_no_model_is_found():
    """Lint finds an option, or a help text, that no model declares."""

    def configure(parser):
        add_settings(parser, RunSettings, only=("seed",))
        parser.add_argument("--json", action="store_true")
        parser.add_argument("--warp", type=float)
        parser.add_argument("--clock", default="realtime")

    assert ["hmrsim x --warp: is not a setting", "hmrsim x --clock: differs from its setting"] == [
        problem.partition(";")[0] for problem in strangers("x", configure, (RunSettings,))
    ]


def test_a_settings_file_of_nonsense_is_wrong_use(tmp_path, monkeypatch, capsys):
    """Each error of a settings file is a line, and the exit code is 2 before anything is served."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "s.yaml").write_text("seed: x\nlisten: [nowhere]\n")

    assert 2 == main(["run", "scenario1", "--settings", "s.yaml"])
    assert [
        "s.yaml:1: seed: expected a whole number, got 'x'",
        "s.yaml:2: listen: 'nowhere' is not an endpoint; expected PROTOCOL/ADDRESS, such as tcp/127.0.0.1:7447",
    ] == capsys.readouterr().err.splitlines()


def test_options_that_do_not_go_together_are_reported_also_of_a_file(tmp_path, monkeypatch, capsys):
    """Conflicting settings of a file are reported like those of the command line."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "s.yaml").write_text("ros_domain_id: 3\n")

    assert 2 == main(["run", "scenario1", "--settings", "s.yaml"])
    assert "hmrsim: --ros-domain-id is for --ros2; add that\n" == capsys.readouterr().err


def test_problems_of_a_settings_file_are_limited(tmp_path, capsys):
    """A thousand errors are reported, and the number of the others."""
    path = tmp_path / "settings.yaml"
    path.write_text("seed: 1\n" * 3_000)
    code = main(["run", "scenario1", "--settings", str(path)])
    lines = capsys.readouterr().err.splitlines()

    assert (2, 1_001, f"{path}: and 1999 more") == (code, len(lines), lines[-1])
