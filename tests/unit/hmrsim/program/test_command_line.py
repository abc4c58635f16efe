"""Parsers whose options are also read from the environment."""

from __future__ import annotations

import argparse

import pytest

from hmrsim.program.command_line import CommandParser, variable_of


@pytest.fixture
def parser():
    """Return a parser with options of every kind."""
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


NEEDED = ["--names", "a"]


def test_the_environment_comes_before_the_default(parser, monkeypatch):
    """A variable gives the option's value, of the option's type."""
    monkeypatch.setenv("HMRSIM_REAL_TIME_FACTOR", "2.5")

    assert 2.5 == parser.parse_args(NEEDED).real_time_factor


@pytest.mark.parametrize("words", [["--seed", "3"], ["--seed=3"]], ids=" ".join)
def test_the_command_line_comes_before_the_environment(parser, monkeypatch, words):
    """The command line wins, even over an invalid variable."""
    monkeypatch.setenv("HMRSIM_SEED", "many")

    assert 3 == parser.parse_args([*NEEDED, *words]).seed


def test_an_empty_variable_is_none(parser, monkeypatch):
    """An empty variable leaves the default."""
    monkeypatch.setenv("HMRSIM_SEED", "")

    assert 7 == parser.parse_args(NEEDED).seed


def test_repeatable_options_take_commas(parser, monkeypatch):
    """Several values are separated by commas; spaces are ignored."""
    monkeypatch.setenv("HMRSIM_CONNECT", "tcp/a:1, tcp/b:2,")

    assert ["tcp/a:1", "tcp/b:2"] == parser.parse_args(NEEDED).connect


def test_the_command_line_does_not_add_to_the_environment(parser, monkeypatch):
    """A repeatable option on the line replaces what the variable lists."""
    monkeypatch.setenv("HMRSIM_CONNECT", "tcp/a:1")

    assert ["tcp/b:2"] == parser.parse_args([*NEEDED, "--connect", "tcp/b:2"]).connect


def test_a_variable_is_enough_for_a_required_option(parser, monkeypatch):
    """A required option may be set by its variable."""
    monkeypatch.setenv("HMRSIM_NAMES", "a,b")

    assert ["a", "b"] == parser.parse_args([]).names


@pytest.mark.parametrize(
    ("variable", "value", "error"),
    [
        ("HMRSIM_SEED", "many", "prog: error: HMRSIM_SEED: 'many' is not a whole number\n"),
        ("HMRSIM_REAL_TIME_FACTOR", "x", "prog: error: HMRSIM_REAL_TIME_FACTOR: 'x' is not a number\n"),
        ("HMRSIM_MODE", "klient", "prog: error: HMRSIM_MODE: no mode 'klient'; did you mean 'client'?\n"),
    ],
)
def test_a_bad_variable_is_named(parser, monkeypatch, capsys, variable, value, error):
    """The error has the variable, its value and what is expected; the exit code is 2."""
    monkeypatch.setenv(variable, value)

    with pytest.raises(SystemExit, match="2"):
        parser.parse_args(NEEDED)
    assert error == capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "error"),
    [
        ([], "prog: error: the following arguments are required: --names; see prog --help\n"),
        (
            [*NEEDED, "--seed", "x"],
            "prog: error: argument --seed: 'x' is not a whole number; see prog --help\n",
        ),
        ([*NEEDED, "--sed", "1"], "prog: error: unrecognized arguments: --sed; did you mean --seed?\n"),
        (
            [*NEEDED, "--mode", "x"],
            "prog: error: argument --mode: no mode 'x'; there are peer, client; see prog --help\n",
        ),
        (
            [*NEEDED, "--seed", "1", "a", "--x\x1b[31m\n"],
            "prog: error: unrecognized arguments: --x\\x1b[31m\\n; see prog --help\n",
        ),
    ],
)
def test_wrong_use_is_one_line(parser, capsys, words, error):
    """The line names the error and the help; the exit code is 2."""
    with pytest.raises(SystemExit, match="2"):
        parser.parse_args(words)
    assert error == capsys.readouterr().err


def test_a_command_rejects_unknown_arguments(capsys):
    """The help of the command has its options, not that of the program."""
    program = CommandParser(prog="prog")
    program.add_subparsers().add_parser("run")

    with pytest.raises(SystemExit, match="2"):
        program.parse_args(["run", "--fast"])
    assert "prog run: error: unrecognized arguments: --fast; see prog run --help\n" == capsys.readouterr().err


def test_help_comes_whatever_the_environment_says(parser, monkeypatch, capsys):
    """A user who has set a bad variable can still read which values are valid."""
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


def test_a_point_is_not_an_option(parser):
    """Negative coordinates can be typed as they are."""
    assert "-3,4.5" == parser.parse_args([*NEEDED, "--seed", "1", "-3,4.5"]).place


def test_the_name_of_a_variable():
    """The variable is the option in capitals, with underscores."""
    action = argparse.ArgumentParser().add_argument("-f", "--feedback-rate")

    assert "HMRSIM_FEEDBACK_RATE" == variable_of(action)
