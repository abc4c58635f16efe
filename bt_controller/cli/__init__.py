"""The command ``bt-controller``: one file for each subcommand."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from typing import Final

from bt_controller.cli._options import EXAMPLES, EXIT_CODES, FAILED, exit_code
from hmrsim import __version__
from hmrsim.errors import printable
from hmrsim.program.command_line import CommandParser, Later, add_commands, autocomplete, run_program

_COMMANDS: Final = {
    "run": "run a tree for each robot",
    "check": "load and check a tree without running it",
    "coverage": "show which nodes the runs of a tree have covered",
    "nodes": "list the nodes of XML trees",
}
"""The subcommands and their help; each is a module of this package with a function *configure*."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    return run_program("bt-controller", lambda: _main(argv))


def _main(argv: Sequence[str] | None) -> int:
    parser = make_parser()
    autocomplete(parser, f"{__name__}._options")
    args = parser.parse_args(argv)
    try:
        code: int = args.function(args)
    except BrokenPipeError:
        # The reader of stdout has gone; Python would report a broken pipe again at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FAILED
    except Exception as error:
        if (known := exit_code(error)) is None:
            raise
        for line in str(error).rstrip("\n").split("\n"):
            print(f"bt-controller: {printable(line)}", file=sys.stderr)
        return known
    return code


def make_parser() -> CommandParser:
    """Return the parser of the program, whose commands have their arguments when they are asked for."""
    parser = CommandParser(
        prog="bt-controller",
        description="Drive robots with behavior trees, as a client of a simulator.",
        epilog=f"{EXAMPLES}\n\n{EXIT_CODES}",
    )
    parser.add_argument("--version", action="version", version=f"bt-controller {__version__}")
    commands = {name: (text, Later(f"{__name__}.{name}", "configure")) for name, text in _COMMANDS.items()}
    add_commands(parser, commands, title="commands")
    return parser
