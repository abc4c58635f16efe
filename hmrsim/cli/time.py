"""``hmrsim time``: pause a running simulation, step it, change its speed."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, Final

from hmrsim.cli.asking import ask
from hmrsim.cli.connection import OPERATOR, connected
from hmrsim.cli.connection_options import add_connection_options
from hmrsim.cli.exits import ExitCode
from hmrsim.cli.output import show, show_json
from hmrsim_zenoh.wire.options import ENVIRONMENT

if TYPE_CHECKING:
    from hmrsim_zenoh.client.client import Client

_EXAMPLES: Final = f"""\
examples:
  hmrsim time pause
  hmrsim time step 10
  hmrsim time resume
  hmrsim time speed 5
  hmrsim time show

{ENVIRONMENT}"""

_PLAYING: Final = 1
_PAUSED: Final = 2
_LONGEST: Final = 1e6


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim time``."""
    parser.description = "Show the time of a running simulation, pause it, step it, change its speed."
    parser.epilog = _EXAMPLES
    commands = parser.add_subparsers(metavar="COMMAND", required=True)

    def add(name: str, text: str, do: Callable[[Client, argparse.Namespace], object]) -> argparse.ArgumentParser:
        command: argparse.ArgumentParser = commands.add_parser(
            name, help=text, description=f"{text[0].upper()}{text[1:]}.", epilog=_of_command(name)
        )
        command.set_defaults(function=lambda args: _do(args, do))
        add_connection_options(command)
        return command

    show_it = add("show", "show the time, its speed, and for whom it waits", lambda _client, _args: None)
    show_it.add_argument("--json", action="store_true", help="print one JSON object")
    add("pause", "let time stand", lambda client, _: _set_state(client, _PAUSED))
    add("resume", "let time go on", lambda client, _: _set_state(client, _PLAYING))
    step = add("step", "advance by some steps while time stands", _step)
    step.add_argument("steps", metavar="STEPS", nargs="?", type=_whole, default=1, help="how many (default: 1)")
    speed = add("speed", "change how much faster than the wall clock time goes", _set_speed)
    speed.add_argument("factor", metavar="FACTOR", type=_factor, help="such as 2; 0 is as fast as possible")


def _of_command(name: str) -> str:
    lines = [line for line in _EXAMPLES.splitlines() if line.startswith(f"  hmrsim time {name}")]
    return "\n".join(["examples:", *lines, "", ENVIRONMENT])


def _whole(text: str) -> int:
    number = int(text) if text.isascii() and text.isdigit() else 0
    if number < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of steps; expected a whole number from 1")
    return number


def _factor(text: str) -> float:
    try:
        factor = float(text)
    except ValueError:
        factor = -1.0
    if not 0 <= factor <= _LONGEST:
        raise argparse.ArgumentTypeError(f"{text!r} is not a speed; expected a number of at least 0, such as 2")
    return factor


def _set_state(client: Client, state: int) -> None:
    ask(client, "set_simulation_state", state={"state": state})


def _step(client: Client, args: argparse.Namespace) -> None:
    ask(client, "step_simulation", steps=args.steps)


def _set_speed(client: Client, args: argparse.Namespace) -> None:
    client.get(client.keys.world("time/set"), payload=json.dumps({"real_time_factor": args.factor}).encode())


def _do(args: argparse.Namespace, do: Callable[[Client, argparse.Namespace], object]) -> int:
    with connected(args, OPERATOR) as (client, _):
        do(client, args)
        state: dict[str, Any] = json.loads(client.get(client.keys.world("time/state")))
    if getattr(args, "json", False):
        show_json(state)
    else:
        show(", ".join(_told(state)))
    return ExitCode.DONE


def _told(state: dict[str, Any]) -> Iterable[str]:
    yield f"{state['now']:.3f} s"
    factor = state["real_time_factor"]
    speed = "as fast as possible" if factor == 0 else f"{factor:g} times real time"
    yield "lockstep" if state["clock"] == "lockstep" else speed
    if state["paused"]:
        yield "paused"
    if state.get("waiting_for"):
        yield f"waiting for {', '.join(state['waiting_for'])}"
