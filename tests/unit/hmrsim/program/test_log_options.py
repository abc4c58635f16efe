"""The log level of a command."""

from __future__ import annotations

import logging

import pytest

from hmrsim.program.command_line import CommandParser
from hmrsim.program.log_options import LineFormatter, add_log_options, log_level, logging_to_stderr


@pytest.fixture
def parser():
    """Return a parser with the option."""
    made = CommandParser()
    add_log_options(made)
    return made


@pytest.mark.parametrize(("words", "level"), [([], logging.WARNING), (["--log-level", "debug"], logging.DEBUG)])
def test_levels_are_those_of_logging(parser, words, level):
    """The default is warnings."""
    assert level == log_level(parser.parse_args(words))


def test_the_environment_says_the_level(parser, monkeypatch):
    """``HMRSIM_LOG_LEVEL`` sets the option."""
    monkeypatch.setenv("HMRSIM_LOG_LEVEL", "error")

    assert logging.ERROR == log_level(parser.parse_args([]))


def test_records_at_the_level_go_to_stderr(parser, capsys):
    """Records below the level are omitted, and all records after the context."""
    log = logging.getLogger("hmrsim_zenoh.some_module")
    with logging_to_stderr(parser.parse_args(["--log-level", "info"])):
        log.debug("too small")
        log.info("told")
    log.error("too late")

    captured = capsys.readouterr()
    assert ("", "[INFO] told\n") == (captured.out, captured.err.replace("too late\n", ""))


def test_a_long_line_is_cut_where_it_says_so():
    """Only long lines are truncated, not the other lines of a traceback."""
    record = logging.LogRecord("hmrsim", logging.INFO, __file__, 1, "first\n%s\nlast", ("x" * 3000,), None)

    assert f"first\n{'x' * 2000} … (3000 characters)\nlast" == LineFormatter("%(message)s").format(record)
