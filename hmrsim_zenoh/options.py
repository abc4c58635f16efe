"""The options of every command that opens a session, on the command line and in the environment.

What the command line says comes first, then ``HMRSIM_CONNECT`` and its like, then the default.
"""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeVar, cast

from hmrsim_zenoh.errors import BadOptions

if TYPE_CHECKING:
    import argparse
    from collections.abc import Callable

    from hmrsim_zenoh.session import Mode, SessionOptions

T = TypeVar("T")

ENVIRONMENT: Final = """\
environment:
  HMRSIM_CONNECT, HMRSIM_LISTEN (several with commas), HMRSIM_MODE, HMRSIM_ZENOH_CONFIG, HMRSIM_PREFIX
  and HMRSIM_TIMEOUT stand for the options of the same name"""
"""For the end of a command's ``--help``."""

_MODES: Final = ("peer", "client", "router")


def add_session_options(parser: argparse.ArgumentParser) -> None:
    """Give a command the options that say where the simulator is."""
    group = parser.add_argument_group("session")
    group.add_argument(
        "--connect",
        action="append",
        metavar="ENDPOINT",
        help="connect there, such as tcp/10.0.0.7:7447; repeatable (default: tcp/127.0.0.1:7447)",
    )
    group.add_argument("--listen", action="append", metavar="ENDPOINT", help="listen there; repeatable")
    group.add_argument("--mode", choices=_MODES, help="Zenoh's mode")
    group.add_argument(
        "--zenoh-config",
        type=Path,
        metavar="FILE.json5",
        help="a configuration of Zenoh's; options come first",
    )
    group.add_argument("--prefix", metavar="KEY", help="what all keys begin with (default: hmrsim)")
    group.add_argument("--timeout", type=float, metavar="S", help="wall seconds to reach a simulator (default: 5)")


def session_options(args: argparse.Namespace) -> SessionOptions:
    """Return what the command line and the environment say.

    Raises:
        BadOptions: A value makes no sense; the text names the option or the variable.
    """
    # Zenoh takes longer to load than --help may.
    from hmrsim_zenoh.session import SessionOptions  # noqa: PLC0415

    default = SessionOptions()
    return SessionOptions(
        connect=_chosen(args.connect, "connect", default.connect, _endpoints),
        listen=_chosen(args.listen, "listen", default.listen, _endpoints),
        mode=_chosen(args.mode, "mode", default.mode, _mode),
        config_file=_chosen(args.zenoh_config, "zenoh-config", default.config_file, Path),
        prefix=_chosen(args.prefix, "prefix", default.prefix, str),
        timeout=_chosen(args.timeout, "timeout", default.timeout, _seconds),
    )


def _chosen(given: Any, option: str, default: T, read: Callable[[Any], T]) -> T:
    """Return an option's value: as given, else from the environment, else the default."""
    variable = f"HMRSIM_{option.replace('-', '_').upper()}"
    name, value = (f"--{option}", given) if given is not None else (variable, os.environ.get(variable))
    if value is None or value == "":
        return default
    try:
        return read(value)
    except ValueError as error:
        raise BadOptions(f"{name}: {error}") from None


def _endpoints(value: str | list[str]) -> tuple[str, ...]:
    parts = value.split(",") if isinstance(value, str) else value
    return tuple(part.strip() for part in parts if part.strip())


def _mode(value: str) -> Mode:
    if value not in _MODES:
        raise ValueError(f"no mode {value!r}; there are {', '.join(_MODES)}")
    return cast("Mode", value)


def _seconds(value: str | float) -> float:
    try:
        seconds = float(value)
    except ValueError:
        seconds = math.nan
    if not (seconds > 0 and math.isfinite(seconds)):
        raise ValueError(f"{value!r} is no time; a number of seconds greater than 0 is expected")
    return seconds
