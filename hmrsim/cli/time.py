"""``hmrsim time``: pause a running simulation, step it, change its speed."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, Final

from hmrsim.cli.connection import OPERATOR, call, connected, value_of
from hmrsim.cli.options import ExitCode, add_connection_options, add_json, number_in, whole_in
from hmrsim.cli.output import show_result
from hmrsim.program.command_line import add_commands

if TYPE_CHECKING:
    from hmrsim.program.command_line import CommandParser
    from hmrsim_zenoh.client.client import Client

_EXAMPLES: Final = """\
examples:
  hmrsim time pause
  hmrsim time step 10
  hmrsim time resume
  hmrsim time speed 5
  hmrsim time show"""

_PLAYING: Final = {"state": 1}
_PAUSED: Final = {"state": 2}
_STEPS: Final = whole_in(1, 2**64 - 1, "a number of steps; expected a whole number from 1")
_FACTOR: Final = number_in(-math.ulp(0.0), 1e6, "a speed; expected a number of at least 0, such as 2")


def configure(parser: CommandParser) -> None:
    """Add the commands of ``hmrsim time``."""
    parser.description = "Show the time of a running simulation, pause it, step it, change its speed."
    parser.epilog = _EXAMPLES
    add_commands(
        parser,
        {
            "show": ("show the time, its speed, and the participants that it waits for", _configure_show),
            "pause": ("pause time", _configure_pause),
            "resume": ("resume time", _configure_resume),
            "step": ("advance by a number of steps while time is paused", _configure_step),
            "speed": ("set the speed of time relative to real time", _configure_speed),
        },
    )


def _configure_show(parser: argparse.ArgumentParser) -> None:
    add_json(parser)
    _add(parser, "show", lambda _client, _args: None)


def _configure_pause(parser: argparse.ArgumentParser) -> None:
    _add(parser, "pause", lambda client, _args: call(client, "set_simulation_state", state=_PAUSED))


def _configure_resume(parser: argparse.ArgumentParser) -> None:
    _add(parser, "resume", lambda client, _args: call(client, "set_simulation_state", state=_PLAYING))


def _configure_step(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("steps", metavar="STEPS", nargs="?", type=_STEPS, default=1, help="how many (default: 1)")
    _add(parser, "step", lambda client, args: call(client, "step_simulation", steps=args.steps))


def _configure_speed(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("factor", metavar="FACTOR", type=_FACTOR, help="such as 2; 0 is as fast as possible")
    _add(parser, "speed", lambda client, args: call(client, "time/set", real_time_factor=args.factor))


def _add(parser: argparse.ArgumentParser, name: str, do: Callable[[Client, argparse.Namespace], object]) -> None:
    """Add the examples, the function and the connection options of a command."""
    lines = [line for line in _EXAMPLES.splitlines() if line.startswith(f"  hmrsim time {name}")]
    parser.epilog = "\n".join(["examples:", *lines])
    parser.set_defaults(function=lambda args: _do(args, do))
    add_connection_options(parser)


def _do(args: argparse.Namespace, do: Callable[[Client, argparse.Namespace], object]) -> int:
    with connected(args, OPERATOR) as (client, _):
        do(client, args)
        state: dict[str, Any] = value_of(client, "time/state")
    show_result(state, ", ".join(_described(state)), as_json=getattr(args, "json", False))
    return ExitCode.DONE


def _described(state: dict[str, Any]) -> Iterable[str]:
    yield f"{state['now']:.3f} s"
    factor = state["real_time_factor"]
    speed = "as fast as possible" if factor == 0 else f"{factor:g} times real time"
    yield "lockstep" if state["clock"] == "lockstep" else speed
    if state["paused"]:
        yield "paused"
    if state.get("waiting_for"):
        yield f"waiting for {', '.join(state['waiting_for'])}"
