"""Parsers whose options are also read from the environment."""

from __future__ import annotations

import argparse
import logging

import pytest

from hmrsim.program.command_line import CommandParser, variable_of
from hmrsim.program.log_options import LineFormatter, add_log_options, log_level, logging_to_stderr

NEEDED = ["--names", "a"]


@pytest.fixture
def parser():
    made = CommandParser(prog="prog")
    made.add_argument("--seed", type=int, default=7)
    made.add_argument("--mode", choices=["peer", "client"])
    made.add_argument("--real-time-factor", type=float)
    made.add_argument("--connect", action="append")
    made.add_argument("--names", nargs="+", required=True)
    made.add_argument("--robot", action="append", default=[])
    made.add_argument("--json", action="store_true")
    made.add_argument("place", nargs="?")
    return made


@pytest.mark.parametrize(
    ("variable", "text", "words", "value"),
    [
        ("REAL_TIME_FACTOR", "2.5", NEEDED, 2.5),
        ("SEED", "many", [*NEEDED, "--seed", "3"], 3),
        ("SEED", "many", [*NEEDED, "--seed=3"], 3),
        ("SEED", "", NEEDED, 7),
        ("CONNECT", "tcp/a:1, tcp/b:2,", NEEDED, ["tcp/a:1", "tcp/b:2"]),
        ("CONNECT", "tcp/a:1", [*NEEDED, "--connect", "tcp/b:2"], ["tcp/b:2"]),
        ("NAMES", "a,b", [], ["a", "b"]),
    ],
)
def test_the_command_line_overrides_the_environment_which_overrides_the_default(
    parser, monkeypatch, variable, text, words, value
):
    """A variable lists values with commas, and can set a required option; an empty one is ignored."""
    monkeypatch.setenv(f"HMRSIM_{variable}", text)

    assert value == getattr(parser.parse_args(words), variable.lower())


@pytest.mark.parametrize(
    ("variable", "value", "error"),
    [
        ("HMRSIM_SEED", "many", "prog: HMRSIM_SEED: 'many' is not a whole number\n"),
        ("HMRSIM_REAL_TIME_FACTOR", "x", "prog: HMRSIM_REAL_TIME_FACTOR: 'x' is not a number\n"),
        ("HMRSIM_MODE", "klient", "prog: HMRSIM_MODE: no mode 'klient'; did you mean 'client'?\n"),
    ],
)
def test_an_invalid_variable_is_named(parser, monkeypatch, capsys, variable, value, error):
    monkeypatch.setenv(variable, value)

    with pytest.raises(SystemExit, match="2"):
        parser.parse_args(NEEDED)
    assert error == capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "error"),
    [
        ([], "prog: the following arguments are required: --names; see prog --help\n"),
        ([*NEEDED, "--seed", "x"], "prog: argument --seed: 'x' is not a whole number; see prog --help\n"),
        ([*NEEDED, "--sed", "1"], "prog: unrecognized arguments: --sed; did you mean --seed?\n"),
        (
            [*NEEDED, "--mode", "x"],
            "prog: argument --mode: no mode 'x'; there are peer, client; see prog --help\n",
        ),
        (
            [*NEEDED, "--seed", "1", "a", "--x\x1b[31m\n"],
            "prog: unrecognized arguments: --x\\x1b[31m\\n; see prog --help\n",
        ),
    ],
)
def test_wrong_use_is_one_line(parser, capsys, words, error):
    with pytest.raises(SystemExit, match="2"):
        parser.parse_args(words)
    assert error == capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "error"),
    [(["--fast"], "--fast"), (["{x:", "1,", "y:", "2}"], "{x: 1, y: 2}; quote YAML, as in '{pose: counter}'")],
)
def test_a_command_rejects_unknown_arguments(capsys, words, error):
    program = CommandParser(prog="prog")
    program.add_subparsers().add_parser("run")

    with pytest.raises(SystemExit, match="2"):
        program.parse_args(["run", *words])
    assert f"prog: unrecognized arguments: {error}; see prog run --help\n" == capsys.readouterr().err


def test_help_ignores_invalid_variables(parser, monkeypatch, capsys):
    monkeypatch.setenv("HMRSIM_SEED", "many")

    with pytest.raises(SystemExit, match="0"):
        parser.parse_args(["--help"])
    assert capsys.readouterr().out.startswith("usage: prog")


def test_per_run_options_have_no_variable(parser, monkeypatch):
    """A leftover variable must not add a robot."""
    monkeypatch.setenv("HMRSIM_ROBOT", "eve@1,2")
    monkeypatch.setenv("HMRSIM_JSON", "1")

    args = parser.parse_args(NEEDED)
    assert ([], False) == (args.robot, args.json)


def test_negative_coordinates_are_no_options(parser):
    assert "-3,4.5" == parser.parse_args([*NEEDED, "--seed", "1", "-3,4.5"]).place


def test_variables_are_named_after_options():
    action = argparse.ArgumentParser().add_argument("-f", "--feedback-rate")

    assert "HMRSIM_FEEDBACK_RATE" == variable_of(action)


@pytest.fixture
def log_parser():
    made = CommandParser()
    add_log_options(made)
    return made


@pytest.mark.parametrize(("words", "level"), [([], logging.WARNING), (["--log-level", "debug"], logging.DEBUG)])
def test_the_default_level_is_warning(log_parser, words, level):
    assert level == log_level(log_parser.parse_args(words))


def test_a_variable_sets_the_level(log_parser, monkeypatch):
    monkeypatch.setenv("HMRSIM_LOG_LEVEL", "error")

    assert logging.ERROR == log_level(log_parser.parse_args([]))


def test_records_at_the_level_go_to_stderr(log_parser, capsys):
    log = logging.getLogger("hmrsim_zenoh.some_module")
    with logging_to_stderr(log_parser.parse_args(["--log-level", "info"])):
        log.debug("too small")
        log.info("told")
    log.error("too late")

    captured = capsys.readouterr()
    assert ("", "[INFO] told\n") == (captured.out, captured.err.replace("too late\n", ""))


def test_only_long_lines_are_cut():
    record = logging.LogRecord("hmrsim", logging.INFO, __file__, 1, "first\n%s\nlast", ("x" * 3000,), None)

    assert f"first\n{'x' * 2000} … (3000 characters)\nlast" == LineFormatter("%(message)s").format(record)
