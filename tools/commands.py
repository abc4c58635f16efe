"""Writes the reference of the command line from the parsers of both programs.

Run as ``python -m tools.commands [--check]``; docs/reference/cli.md is generated.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

from bt_controller.cli import make_parser as make_bt_controller
from hmrsim.cli import make_parser as make_hmrsim
from hmrsim.program.command_line import CommandParser

_PAGE: Final = Path("docs/reference/cli.md")
_EVERYWHERE: Final = "session"
"""The group of options that each command has that opens a session: they are told once."""
_HEAD: Final = """\
# Command line

<!-- generated from the parsers by `make schemas`, not to be edited -->

You can also set options with a value as environment variables, such as `HMRSIM_CONNECT`. The command line wins.
The `--help` of each command has examples and its exit codes, which [error codes](errors/index.md) explains.
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Write the page, or report that it is out of date."""
    parser = argparse.ArgumentParser(prog="python -m tools.commands", description=main.__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 if something is wrong")
    arguments = parser.parse_args(argv)
    new = "\n".join([_HEAD, *_session(make_hmrsim()), *_of(make_hmrsim(), 2), *_of(make_bt_controller(), 2)]) + "\n"
    if arguments.check and _PAGE.read_text(encoding="utf-8") != new:
        sys.stderr.write(f"{_PAGE}: out of date; run make schemas\n")
        return 1
    if not arguments.check:
        _PAGE.write_text(new, encoding="utf-8")
    return 0


def _of(parser: argparse.ArgumentParser, level: int) -> Iterator[str]:
    """Yield the sections of a parser and of its commands."""
    if isinstance(parser, CommandParser):
        parser.load()
    commands = _commands(parser)
    yield f"{'#' * min(level, 4)} {parser.prog}\n"
    if parser.description:
        yield f"{parser.description}\n"
    if commands:
        yield "| command | |\n|---|---|"
        yield from (f"| [`{name}`](#{_anchor(each.prog)}) | {_cell(text)} |" for name, (each, text) in commands.items())
        yield ""
    rows = list(_arguments(parser))
    if rows:
        yield "| argument | |\n|---|---|"
        yield from rows
        yield ""
    if any(group.title == _EVERYWHERE for group in parser._action_groups):  # noqa: SLF001 - argparse has no public attribute for it
        yield "[Options of a session](#options-of-a-session) are available, too.\n"
    for each, _ in commands.values():
        yield from _of(each, level + 1)


def _commands(parser: argparse.ArgumentParser) -> dict[str, tuple[argparse.ArgumentParser, str]]:
    """Return the commands of a parser with the lines that help has of them; aliases are left out."""
    found: dict[str, tuple[argparse.ArgumentParser, str]] = {}
    for action in parser._actions:  # noqa: SLF001 - as above
        if isinstance(action, argparse._SubParsersAction):  # noqa: SLF001
            texts = {choice.dest.split(" ")[0]: choice.help or "" for choice in action._choices_actions}  # noqa: SLF001
            found |= {name: (action.choices[name], text) for name, text in texts.items()}
    return found


def _arguments(parser: argparse.ArgumentParser, *, of: str = "") -> Iterator[str]:
    for group in parser._action_groups:  # noqa: SLF001
        if (group.title == _EVERYWHERE) == bool(of):
            yield from (_row(parser, action) for action in group._group_actions if _is_told(action))  # noqa: SLF001


def _is_told(action: argparse.Action) -> bool:
    return not isinstance(action, (argparse._SubParsersAction, argparse._HelpAction)) and (  # noqa: SLF001
        action.help is not argparse.SUPPRESS
    )


def _row(parser: argparse.ArgumentParser, action: argparse.Action) -> str:
    value = "" if action.nargs == 0 else _value(action)
    names = [f"`{f'{name} {value}'.strip()}`" for name in action.option_strings] or [f"`{value}`"]
    text = (action.help or "") % {**vars(action), "prog": parser.prog}
    return f"| {', '.join(names)} | {_cell(text)} |"


def _value(action: argparse.Action) -> str:
    metavar = action.metavar
    if isinstance(metavar, tuple):
        metavar = " ".join(metavar)
    if metavar is None:
        metavar = "{" + ",".join(map(str, action.choices)) + "}" if action.choices else action.dest.upper()
    many = {"?": f"[{metavar}]", "*": f"[{metavar} ...]", "+": f"{metavar} ..."}
    return many.get(str(action.nargs), metavar)


def _session(program: argparse.ArgumentParser) -> Iterator[str]:
    """Yield the section about the options of sessions, from a command that has them."""
    command = _commands(program)["doctor"][0]
    if isinstance(command, CommandParser):
        command.load()
    yield "## Options of a session\n\n| option | |\n|---|---|"
    yield from _arguments(command, of=_EVERYWHERE)
    yield ""


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")


def _anchor(prog: str) -> str:
    return prog.replace(" ", "-")


if __name__ == "__main__":
    sys.exit(main())
