"""The parsers of programs and their commands."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hmrsim.program.command_line import CommandParser


def parsers_of(parser: CommandParser) -> Iterator[CommandParser]:
    """Yield a parser and those of all commands below it, with their arguments."""
    parser.load()
    yield parser
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            # An alias has the parser of its command.
            for command in dict.fromkeys(action.choices.values()):
                yield from parsers_of(command)
