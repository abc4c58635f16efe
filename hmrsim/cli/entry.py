"""From a command line to an exit code: the only place that ends the process with an error."""

from __future__ import annotations

import argparse
import importlib
import os
import sys
from typing import TYPE_CHECKING, Any, Final

from hmrsim import __version__
from hmrsim.errors import HmrsimError

if TYPE_CHECKING:
    from collections.abc import Sequence

_COMMANDS: Final = {
    "run": "serve a world over Zenoh until Ctrl-C",
    "simulate": "run the robots' own scripts in virtual time, without a network",
    "demo": "watch a fleet do its work in the hospital, from start to end",
    "action": "list the robots' actions, look at one, send a goal",
    "topic": "list what is published, and follow it",
    "map": "check a world file",
}
"""Each is a module of this package with a function *configure*, which adds arguments to the command's parser."""

_EXIT_CODES: Final = """\
exit codes:
  0  done
  1  it ran and did not succeed: goal rejected, aborted or canceled, unknown robot or action, errors found
  2  wrong use, unreadable input, port taken
  3  nobody there: no simulator answers within --timeout
  130  Ctrl-C while following a goal, which cancels it

examples:
  hmrsim demo
  hmrsim run scenario1
  hmrsim action send-goal /wall_e/navigate_to_pose '{pose: {pose: {position: {x: 512, y: 215}}}}'"""

_DONE: Final = 0
_INTERRUPTED: Final = 130


class _CommandParser(argparse.ArgumentParser):
    """A parser that gets its arguments when its command is the one asked for.

    Most commands load Zenoh and pydantic, which takes longer than ``hmrsim --help`` may.
    """

    def __init__(self, *, command: str | None = None, **options: Any) -> None:
        options.setdefault("formatter_class", argparse.RawDescriptionHelpFormatter)
        super().__init__(allow_abbrev=False, **options)
        self._command = command

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> tuple[Any, list[str]]:
        """Parse, after the command's module has added its arguments."""
        if self._command is not None:
            module = importlib.import_module(f"{__package__}.{self._command}")
            self._command = None
            module.configure(self)
        return super().parse_known_args(args, namespace)


def _parser() -> argparse.ArgumentParser:
    parser = _CommandParser(
        prog="hmrsim", description="A mission-level simulator of robots, driven over Zenoh.", epilog=_EXIT_CODES
    )
    parser.add_argument("--version", action="version", version=f"hmrsim {__version__}")
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    for name, summary in _COMMANDS.items():
        commands.add_parser(name, help=summary, command=name)
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code.

    Args:
        argv: What stands behind ``hmrsim`` on the command line; that of this process if None.
    """
    try:
        args = _parser().parse_args(argv)
        code: int = args.function(args)
        sys.stdout.flush()
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else _DONE
    except HmrsimError as error:
        # Imports Zenoh, which whoever raised the error has done already.
        from hmrsim.cli.exits import code_of, text_of  # noqa: PLC0415

        print(text_of(error), file=sys.stderr)
        return code_of(error)
    except BrokenPipeError:
        # Whoever read our output has seen enough. Python would complain once more when it flushes at its end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return _DONE
    except KeyboardInterrupt:
        return _INTERRUPTED
    return code
