"""From a command line to an exit code: the only place that ends the process with an error."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from typing import Final

from hmrsim import __version__
from hmrsim.errors import HmrsimError
from hmrsim.program.command_line import ENVIRONMENT, LazyParser, add_commands, autocomplete, run_program
from hmrsim.program.garbage import raise_thresholds

_COMMANDS: Final = {
    "run": "serve a world over Zenoh until Ctrl-C",
    "simulate": "run the robots' own scripts in virtual time, without a network",
    "replay": "replay a trace, and check that the run is identical",
    "demo": "run a hospital mission: simulator and controller, each in its own process",
    "robot": "list the robots, where they are and what they do",
    "action": "list the robots' actions, show one, send a goal",
    "topic": "list topics, print their messages, measure their rate",
    "service": "list services, and call them",
    "fault": "let something go wrong in a running simulation, list faults, end them",
    "time": "show the time of a running simulation, pause it, step it, change its speed",
    "security": "let only those drive robots who have a certificate for it: make it, check it, explain it",
    "doctor": "diagnose the network: simulators, clients, ROS nodes",
    "view": "show a simulation in a browser, live or recorded",
    "record": "record what is published to an MCAP file, for Foxglove and `hmrsim view`",
    "report": "report on a trace or a recording, as a page, as JSON or as tables",
    "experiment": "run a world many times, and say what came of it",
    "check": "find the faults that break a controller, or apply properties to a trace",
    "compare": "compare two controllers run by run, or two traces line by line",
    "world": "list the worlds that are shipped, begin a world, print the schema",
    "map": "check, inspect, convert and draw world files; plan routes on them",
    "explain": "explain an error code, a reason, a cause or an exit code",
    "completion": "print a script for shell completion",
}
"""Each is a module of this package with a function *configure*, which adds arguments to the command's parser."""

_EPILOG: Final = f"""\
exit codes:
  0  done
  1  it ran, but did not succeed: goal rejected, aborted or canceled, unknown robot or action, errors found
  2  wrong use, unreadable input, port taken
  3  no simulator answers within --timeout
  130  Ctrl-C while following a goal, which cancels it
  143  SIGTERM while following a goal, which cancels it

examples:
  hmrsim demo
  hmrsim run scenario1
  hmrsim action send-goal /mocha/navigate_to_pose '{{pose: counter}}'

{ENVIRONMENT}"""

_DONE: Final = 0


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the program, whose commands have their arguments when they are asked for."""
    parser = LazyParser(
        prog="hmrsim", description="A mission-level simulator of robots, driven over Zenoh.", epilog=_EPILOG
    )
    parser.add_argument("--version", action="version", version=f"hmrsim {__version__}")
    add_commands(parser, _COMMANDS, f"{__package__}.")
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code.

    Args:
        argv: What stands behind ``hmrsim`` on the command line; that of this process if None.
    """
    return run_program("hmrsim", lambda: _run(argv))


def _run(argv: Sequence[str] | None) -> int:
    raise_thresholds()
    try:
        parser = make_parser()
        autocomplete(parser, f"{__package__}.completers")
        args = parser.parse_args(argv)
        code: int = args.function(args)
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else _DONE
    except HmrsimError as error:
        # Imports Zenoh, which the code that raised the error has imported already.
        from hmrsim.cli import exits  # noqa: PLC0415

        print(exits.text_of(error), file=sys.stderr)
        return exits.code_of(error)
    return code
