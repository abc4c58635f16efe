"""The option ``--log-level``, and logging to stderr."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Final, Literal

from hmrsim.settings.arguments import add_settings
from hmrsim.settings.option import Option

if TYPE_CHECKING:
    import argparse

PACKAGES: Final = ("hmrsim", "hmrsim_zenoh", "bt_controller")
"""Our packages, whose loggers get the level; other loggers keep theirs."""
_FORMAT: Final = "[%(levelname)s] %(message)s"

_MAX_LINE: Final = 2_000
"""Maximum characters of a line of the log."""

_Level = Annotated[Literal["debug", "info", "warning", "error"], Option("log to stderr at this level and above")]


@dataclass(frozen=True)
class LogOptions:
    """The log level of a command."""

    log_level: _Level = "warning"


@dataclass(frozen=True)
class ServerLogOptions(LogOptions):
    """The log level of a simulator, whose log is its user interface."""

    log_level: _Level = "info"


def add_log_options(parser: argparse.ArgumentParser, *, default: str = "warning") -> None:
    """Add ``--log-level`` to a command."""
    add_settings(parser, LogOptions, defaults={"log_level": default})


def log_level(args: argparse.Namespace | LogOptions) -> int:
    """Return the level of a command as a number of :mod:`logging`."""
    return logging.getLevelNamesMapping()[args.log_level.upper()]


class LineFormatter(logging.Formatter):
    """Formats records, and truncates long lines, which may contain anything that clients send."""

    def format(self, record: logging.LogRecord) -> str:
        """Return the record's lines."""
        text = super().format(record)
        return text if len(text) <= _MAX_LINE else "\n".join(_cut(line) for line in text.splitlines())


def _cut(line: str) -> str:
    return line if len(line) <= _MAX_LINE else f"{line[:_MAX_LINE]} … ({len(line)} characters)"


@contextmanager
def logging_to_stderr(args: argparse.Namespace) -> Iterator[None]:
    """Log our packages to stderr within the context, for commands without another log."""
    handler = logging.StreamHandler()
    handler.setFormatter(LineFormatter(_FORMAT))
    loggers = [logging.getLogger(name) for name in PACKAGES]
    before = [logger.level for logger in loggers]
    for logger in loggers:
        logger.addHandler(handler)
        logger.setLevel(log_level(args))
    try:
        yield
    finally:
        for logger, level in zip(loggers, before, strict=True):
            logger.removeHandler(handler)
            logger.setLevel(level)
