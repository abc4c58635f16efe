"""The command ``hmrsim``: from a command line to an exit code; one file for each family of commands.

A command turns options into settings, and passes them to a host, a simulator or a client.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from contextlib import nullcontext
from typing import TYPE_CHECKING, Final

from hmrsim.program.signals import INTERRUPTED, leave, must_leave, on_signals

if TYPE_CHECKING:
    from hmrsim.program.command_line import CommandParser

_SERVING: Final = ("run", "view", "record")
"""Commands that a signal ends successfully, whenever it arrives."""

_COMMANDS: Final = {
    "run simulations": {
        "run": "serve a world over Zenoh until Ctrl-C",
        "simulate": "run the robots' own scripts in virtual time, without a network",
        "replay": "replay a trace, and check that the run is identical",
        "demo": "run a hospital mission: simulator and controller, each in its own process",
    },
    "drive robots": {
        "robot": "list the robots with their poses and activities",
        "action": "list and describe the robots' actions, and send goals",
        "topic": "list topics, print their messages and measure their rates",
        "service": "list services, and call them",
        "fault": "inject, list and clear faults in a running simulation",
        "time": "show, pause, step and speed up the time of a running simulation",
    },
    "see what happens": {
        "view": "show a simulation in a browser, live or recorded",
        "record": "record all published messages to an MCAP file, for Foxglove and `hmrsim view`",
        "report": "report on a trace or a recording, as a page, as JSON or as tables",
        "explain": "explain an error code, a reason, a cause or an exit code, or why robots wait",
    },
    "make worlds": {
        "map": "list, create, check, inspect, convert and draw worlds; plan routes on them",
    },
    "test controllers": {
        "check": "find the faults that break a controller, or apply properties to a trace",
        "experiment": "run a world many times and summarize the results",
        "compare": "compare two controllers run by run, or two traces line by line",
    },
    "administer": {
        "doctor": "diagnose the network: simulators, clients, ROS nodes",
        "security": "restrict who may drive robots, with certificates",
        "completion": "print a script for shell completion",
    },
}
"""The commands and their help, by purpose; each is a module of this package with a function *configure*."""

_EPILOG: Final = """\
exit codes:
  0  done
  1  it ran, but did not succeed: goal rejected, aborted or canceled, unknown robot, action or place, errors found
  2  wrong use, unreadable input, port taken
  3  no simulator answers within --timeout
  130  Ctrl-C while following a goal, which cancels it
  143  SIGTERM while following a goal, which cancels it

examples:
  hmrsim demo
  hmrsim run scenario1
  hmrsim action send-goal /mocha/navigate_to_pose '{pose: counter}'
"""

_DONE: Final = 0


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code.

    Args:
        argv: The arguments after ``hmrsim``; those of this process if None.
    """
    words = sys.argv[1:] if argv is None else argv
    try:
        # Signals are handled before anything slow is imported.
        with on_signals(_end) if words and words[0] in _SERVING else nullcontext():
            from hmrsim.program.command_line import run_program

            code = run_program("hmrsim", lambda: _run(argv))
    except KeyboardInterrupt:
        code = INTERRUPTED
    if argv is None and must_leave(code):
        leave(code)
    return code


def _end(_number: int) -> None:
    """End the process at once: no client is served yet.

    Python would ignore an exception in some places, such as its own callbacks during an import.
    """
    os._exit(_DONE)


def make_parser() -> CommandParser:
    """Return the parser of the program; each command adds its arguments when it is used."""
    from hmrsim import __version__
    from hmrsim.program.command_line import ENVIRONMENT, CommandParser, Later, add_commands

    parser = CommandParser(
        prog="hmrsim",
        description="A mission-level simulator of robots, driven over Zenoh.",
        epilog=f"{_EPILOG}\n{ENVIRONMENT}",
        groups=_COMMANDS,
    )
    parser.add_argument("--version", action="version", version=f"hmrsim {__version__}")
    commands = {name: text for group in _COMMANDS.values() for name, text in group.items()}
    add_commands(parser, {name: (text, Later(f"{__name__}.{name}", "configure")) for name, text in commands.items()})
    return parser


def _asking_for_help(words: Sequence[str]) -> Sequence[str]:
    """Return ``[COMMAND …] --help`` for ``help [COMMAND …]`` and for no arguments, and other arguments unchanged."""
    if not words or words[0] == "help":
        return [*words[1:], "--help"]
    return words


def _run(argv: Sequence[str] | None) -> int:
    from hmrsim.errors import HmrsimError
    from hmrsim.program.command_line import autocomplete
    from hmrsim.program.memory import raise_thresholds

    raise_thresholds()
    try:
        parser = make_parser()
        autocomplete(parser, f"{__name__}.completion")
        args = parser.parse_args(_asking_for_help(sys.argv[1:] if argv is None else argv))
        code: int = args.function(args)
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else _DONE
    except HmrsimError as error:
        from hmrsim.cli import options

        print(options.text_of(error), file=sys.stderr)
        return options.code_of(error)
    return code
