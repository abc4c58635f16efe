"""Command-line parsers whose options can also be set with environment variables.

This module loads quickly. A command loads in two steps: its options with `CommandParser`, then its work when it runs.
"""

from __future__ import annotations

import argparse
import errno
import importlib
import os
import re
import sys
from collections.abc import Callable, Generator, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, NoReturn

from hmrsim.diagnostics import meant
from hmrsim.errors import printable, reason_of
from hmrsim.program.files import NO_SPACE

if TYPE_CHECKING:
    Completer = Callable[..., Iterable[str]]
    Configure = Callable[["CommandParser"], None]

ENVIRONMENT: Final = """\
environment:
  HMRSIM_CONNECT, HMRSIM_TIMEOUT, HMRSIM_SEED, … set the options that take a value: HMRSIM_ and the option in
  capitals, with _ for - and commas between values. The command line takes precedence. Per-run options (--robot,
  --item, --goal-id, …) have no environment variable."""
"""The end of the help of each command that has such options."""

_OF_ONE_RUN: Final = frozenset(
    {"--robot", "--robots", "--item", "--page", "--rename", "--goal-id", "--for", "--speed", "--to", "--name", "--role"}
)
"""Per-run options, which have no environment variables: a leftover variable would surprise the user."""

_EXPECTED: Final[Mapping[object, str]] = {int: "a whole number", float: "a number"}

_HELP: Final = {"-h", "--help"}

_DONE: Final = 0
_FAILED: Final = 1
_WRONG_USE: Final = 2
_INTERRUPTED: Final = 130


class CommandParser(argparse.ArgumentParser):
    """A parser that also reads options with a value from ``HMRSIM_<OPTION>``.

    The command line overrides the environment, which overrides the default. Empty variables are ignored.

    Args:
        configure: Adds the arguments to the parser when its command is used; None for none. Many commands load pydantic
            for their options, which would slow down ``--help`` of the program.
        groups: The names of the commands below each heading of the help; by default there are no headings.
        options: As for argparse.
    """

    def __init__(
        self,
        *,
        configure: Configure | None = None,
        groups: Mapping[str, Iterable[str]] = MappingProxyType({}),
        **options: Any,
    ) -> None:
        super().__init__(formatter_class=partial(_Formatter, groups=groups), allow_abbrev=False, **options)
        self._configure = configure
        self._instead: Mapping[str, str] = {}
        # Points such as -3,4 are not options.
        self._negative_number_matcher = re.compile(r"-\.?\d.*", re.DOTALL)

    def load(self) -> None:
        """Add the arguments of the command, once."""
        if (configure := self._configure) is not None:
            self._configure = None
            configure(self)

    def suggest(self, instead: Mapping[str, str]) -> None:
        """Suggest these texts for options that the parser does not have, by the names that people try."""
        self._instead = instead

    def format_help(self) -> str:
        """Return the help, with the environment variables at its end if an option has one."""
        text = super().format_help()
        return f"{text}\n{ENVIRONMENT}\n" if any(map(variable_of, self._actions)) else text

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> tuple[Any, list[str]]:
        """Parse the command line after the environment, and exit on unknown arguments.

        argparse would leave unknown arguments to the main parser, whose help does not list the command's options.
        """
        self.load()
        given = sys.argv[1:] if args is None else list(args)
        if _HELP.isdisjoint(given):
            self._read_environment(given)
        found, unknown = super().parse_known_args(args, namespace)
        if unknown:
            self.error(f"unrecognized arguments: {' '.join(unknown)}{self._suggested_option(unknown)}")
        return found, unknown

    def error(self, message: str) -> NoReturn:
        """Exit with 2 and print one line: the error, and a pointer to the help unless it ends in a suggestion."""
        rest = "" if message.endswith("?") else f"; see {self.prog} --help"
        self.exit(2, f"{self._program}: {printable(message)}{rest}\n")

    @property
    def _program(self) -> str:
        """The program without its command: the prefix of all its error messages."""
        return self.prog.partition(" ")[0]

    def _read_environment(self, given: list[str]) -> None:
        for action in self._actions:
            variable = variable_of(action)
            text = os.environ.get(variable, "") if variable else ""
            if not text or any(word.partition("=")[0] in action.option_strings for word in given):
                continue
            repeatable = isinstance(action, argparse._AppendAction) or action.nargs in ("*", "+")  # noqa: SLF001
            try:
                values = [self._get_value(action, word) for word in (words_of(text) if repeatable else [text])]
                for value in values:
                    self._check_value(action, value)
            except argparse.ArgumentError as error:
                self.exit(2, f"{self._program}: {variable}: {printable(error.message)}\n")
            action.required = False
            self.set_defaults(**{action.dest: values if repeatable else values[0]})

    def _get_value(self, action: argparse.Action, arg_string: str) -> Any:
        """Return the value of an argument; raise our own error if it is not a number."""
        try:
            return super()._get_value(action, arg_string)
        except argparse.ArgumentError:
            if action.type in _EXPECTED:
                raise argparse.ArgumentError(action, f"{arg_string!r} is not {_EXPECTED[action.type]}") from None
            raise

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Check that the value is one of the choices, with our own error."""
        if action.choices is not None and value not in action.choices:
            noun = (action.option_strings[-1].lstrip("-") if action.option_strings else str(action.metavar)).lower()
            choices = ", ".join(str(choice) for choice in action.choices)
            suggestion = meant(str(value), map(str, action.choices))
            rest = f"did you mean {suggestion!r}?" if suggestion else f"there are {choices}"
            raise argparse.ArgumentError(action, f"no {noun} {value!r}; {rest}")

    def _suggested_option(self, unknown: list[str]) -> str:
        """Return the end of an error message: the known option closest to the first unknown one, or to quote YAML."""
        if unknown[-1].endswith("}"):
            return "; quote YAML, as in '{pose: counter}'"
        option = next((word.partition("=")[0] for word in unknown if word.startswith("--")), "")
        known = [name for action in self._actions for name in action.option_strings]
        suggestion = self._instead.get(option) or meant(option, known)
        return f"; did you mean {suggestion}?" if option and suggestion else ""

    def _print_message(self, message: str, file: Any = None) -> None:
        """Print the help, and raise the error that argparse would swallow if stdout can't be written."""
        if file is sys.stdout:
            file.write(message)
        else:
            super()._print_message(message, file)


def words_of(text: str) -> list[str]:
    """Return the comma-separated values of a variable."""
    return [part.strip() for part in text.split(",") if part.strip()]


def variable_of(action: argparse.Action) -> str:
    """Return the environment variable of an option; empty if it has none."""
    names = [name for name in action.option_strings if name.startswith("--")]
    if not names or action.nargs == 0 or not _OF_ONE_RUN.isdisjoint(names):
        return ""
    return f"HMRSIM_{names[0][2:].replace('-', '_').upper()}"


@dataclass(frozen=True)
class Later:
    """A function that is imported when it is called, so that ``--help`` does not load what a command works with."""

    module: str
    name: str

    def loaded(self) -> Callable[..., Any]:
        """Return the function itself."""
        function: Callable[..., Any] = getattr(importlib.import_module(self.module), self.name)
        return function

    def __call__(self, *args: Any) -> Any:
        """Call the function and return its result."""
        return self.loaded()(*args)


class _Formatter(argparse.RawDescriptionHelpFormatter):
    """Shows commands below the headings of their groups."""

    def __init__(self, prog: str, groups: Mapping[str, Iterable[str]]) -> None:
        super().__init__(prog)
        self._groups = groups

    def _iter_indented_subactions(self, action: argparse.Action) -> Generator[argparse.Action, None, None]:
        if not self._groups:
            yield from super()._iter_indented_subactions(action)
            return
        commands = {command.dest: command for command in super()._iter_indented_subactions(action)}
        self._indent()
        for title, names in self._groups.items() if commands else ():
            yield argparse.Action([], title, metavar=f"{title}:")
            self._indent()
            yield from (commands[name] for name in names)
            self._dedent()
        self._dedent()


def add_commands(
    parser: CommandParser, commands: Mapping[str, tuple[str, Configure]], *, title: str | None = None
) -> None:
    """Add subcommands to a parser.

    Args:
        parser: The parser of the program, or of a command.
        commands: A summary of each subcommand, which is also its description by default, and the function that adds
            its arguments when it is used. A name such as ``send-goal`` is also accepted with underscores.
        title: The heading of the list of subcommands, unless they are in groups.
    """
    options: dict[str, Any] = {} if title is None else {"title": title}
    parsers = parser.add_subparsers(metavar="COMMAND", required=True, **options)
    words = os.environ.get("COMP_LINE", "").split() if "_ARGCOMPLETE" in os.environ else ()
    for name, (summary, configure) in commands.items():
        aliases = [name.replace("-", "_")] if "-" in name else []
        description = f"{summary[0].upper()}{summary[1:]}."
        command = parsers.add_parser(name, aliases=aliases, help=summary, description=description, configure=configure)
        if not {name, *aliases}.isdisjoint(words):
            command.load()


def run_program(program: str, run: Callable[[], int]) -> int:
    """Run a program and return its exit code, including when stdout can't be written or Ctrl-C ends it."""
    if sys.stdout is None:
        print(f"{program}: can't write the output: stdout is closed", file=sys.stderr)  # noqa: T201
        return _FAILED
    try:
        code = run()
        sys.stdout.flush()
    except BrokenPipeError:
        # The reader of our output has closed the pipe.
        _mute_stdout()
        return _DONE
    except KeyboardInterrupt:
        return _INTERRUPTED
    except OSError as error:
        if error.errno == errno.ENAMETOOLONG:
            print(f"{program}: {printable(str(error.filename))}: {reason_of(error)}", file=sys.stderr)  # noqa: T201
            return _WRONG_USE
        if error.filename is not None or error.errno not in NO_SPACE:
            raise
        _mute_stdout()
        with suppress(OSError):
            print(f"{program}: can't write the output: {reason_of(error)}", file=sys.stderr)  # noqa: T201
        return _FAILED
    return code


def _mute_stdout() -> None:
    """Discard the output that could not be written: Python would report it again when it flushes at exit."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def autocomplete(parser: argparse.ArgumentParser, completers: str) -> None:
    """Print completions and exit if a shell requests them; otherwise do nothing.

    Args:
        parser: The parser of the program, with the arguments of all commands on the line.
        completers: A module with a mapping COMPLETERS. A key is the metavar of a positional argument, or a command
            and the metavar of any of its arguments, such as ``"hmrsim topic echo NAME"``.
    """
    if "_ARGCOMPLETE" not in os.environ:
        return
    # Takes 20 ms to load, and is only needed here.
    import argcomplete  # noqa: PLC0415

    _attach(parser, importlib.import_module(completers).COMPLETERS)
    argcomplete.autocomplete(parser, always_complete_options=False)


def _attach(parser: argparse.ArgumentParser, completers: Mapping[str, Completer]) -> None:
    for action in parser._actions:  # noqa: SLF001
        if isinstance(action, argparse._SubParsersAction):  # noqa: SLF001
            for command in action.choices.values():
                _attach(command, completers)
            continue
        known = completers.get(f"{parser.prog} {action.metavar}")
        if known is None and not action.option_strings:
            known = completers.get(str(action.metavar))
        if known is not None:
            action.completer = known  # type: ignore[attr-defined]  # as argcomplete expects
