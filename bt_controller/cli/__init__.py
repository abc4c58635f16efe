"""The command ``bt-controller``: one file a command."""

from __future__ import annotations

import argparse
import os
import sys
from typing import TYPE_CHECKING

from bt_controller.cli import check, nodes, run
from bt_controller.cli._codes import EXIT_CODES, FAILED, NOBODY, WRONG_USE
from hmrsim.program.command_line import CommandParser, autocomplete, run_program

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from hmrsim.program.command_line import Completer

# What takes its time to load (py_trees, pydantic, zenoh) is imported where it is needed: --help is quick.
# ruff: noqa: PLC0415


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code."""
    return run_program("bt-controller", lambda: _main(argv))


def _main(argv: Sequence[str] | None) -> int:
    parser = _parser()
    autocomplete(parser, _completers)
    args = parser.parse_args(argv)
    try:
        code: int = args.command(args)
    except BrokenPipeError:
        # Whoever read our output has gone before the end; Python would complain once more on its way out.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FAILED
    except Exception as error:
        if (known := _exit_code(error)) is None:
            raise
        for line in str(error).splitlines():
            print(f"bt-controller: {line}", file=sys.stderr)
        return known
    return code


def _completers() -> Mapping[str, Completer]:
    from bt_controller.running.selection import completions
    from bt_controller.world.directory import Directory
    from hmrsim_zenoh.client.completion import robots, running

    def selectors(parsed_args: argparse.Namespace, **_unused: object) -> list[str]:
        return completions(Directory.from_info(running(parsed_args)))

    return {"bt-controller run NAME": robots, "bt-controller run SELECTOR": selectors}


def _exit_code(error: Exception) -> int | None:
    """Return the exit code of an error whose text is fit to be shown; None for a bug."""
    from bt_controller.core.node import PortError
    from bt_controller.errors import TreeError
    from hmrsim.errors import HmrsimError
    from hmrsim_zenoh.errors import (
        BadOptions,
        NameTaken,
        NobodyThere,
        PortTaken,
        RequestTimeout,
        SimulatorGone,
        Unreachable,
    )

    if isinstance(error, (TreeError, PortError, BadOptions, PortTaken, NameTaken)):
        return WRONG_USE
    if isinstance(error, (NobodyThere, SimulatorGone, Unreachable, RequestTimeout)):
        return NOBODY
    return FAILED if isinstance(error, HmrsimError) else None


def _parser() -> argparse.ArgumentParser:
    parser = CommandParser(
        prog="bt-controller",
        description="Drive robots with behaviour trees, as a client of a simulator.",
        epilog=f"{run.EXAMPLES}\n\n{EXIT_CODES}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for command in (run, check, nodes):
        command.add_parser(commands)
    return parser
