"""The parsers of our commands; environment variables set options that the command line does not.

This module loads quickly. A command is loaded in two steps: its options with `LazyParser`, its work with `Later`.
"""

from __future__ import annotations

import argparse
import errno
import importlib
import os
import re
import sys
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, NoReturn

from hmrsim.errors import printable, reason_of
from hmrsim.program.outputs import NO_SPACE

if TYPE_CHECKING:
    Completer = Callable[..., Iterable[str]]

ENVIRONMENT: Final = """\
environment:
  HMRSIM_CONNECT, HMRSIM_TIMEOUT, HMRSIM_SEED, … stand for options that have a value: HMRSIM_ and the option in
  capitals, _ for -, and commas between several values. The command line comes first. What is of one run only
  (--robot, --item, --goal-id, …) has no variable."""
"""For the end of a command's ``--help``."""

_OF_ONE_RUN: Final = frozenset(
    {"--robot", "--robots", "--item", "--page", "--rename", "--goal-id", "--for", "--speed", "--to", "--name", "--role"}
)
"""Options of a single run, without environment variables: a variable that was left set would be a surprise."""

_EXPECTED: Final[Mapping[object, str]] = {int: "a whole number", float: "a number"}

_HELP: Final = {"-h", "--help"}

_DONE: Final = 0
_FAILED: Final = 1
_WRONG_USE: Final = 2
_INTERRUPTED: Final = 130


class CommandParser(argparse.ArgumentParser):
    """A parser whose options with a value can be given as ``HMRSIM_<OPTION>``, too.

    The command line comes before the environment, which comes before the default. An empty variable is none.
    """

    def __init__(self, **options: Any) -> None:
        options.setdefault("formatter_class", argparse.RawDescriptionHelpFormatter)
        options.setdefault("allow_abbrev", False)
        super().__init__(**options)
        # Points such as -3,4 are not options.
        self._negative_number_matcher = re.compile(r"-\.?\d.*", re.DOTALL)

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> tuple[Any, list[str]]:
        """Parse, after the environment has said what the command line doesn't; refuse what is unknown.

        A command refuses it itself: argparse would leave that to the program, whose help doesn't have its options.
        """
        given = sys.argv[1:] if args is None else list(args)
        if _HELP.isdisjoint(given):
            self._read_environment(given)
        found, unknown = super().parse_known_args(args, namespace)
        if unknown:
            self.error(f"unrecognized arguments: {' '.join(unknown)}{self._meant_option(unknown)}")
        return found, unknown

    def error(self, message: str) -> NoReturn:
        """Exit with 2 and one line that states the error and where to read on, unless it suggests what was meant."""
        rest = "" if message.endswith("?") else f"; see {self.prog} --help"
        self.exit(2, f"{self.prog}: error: {printable(message)}{rest}\n")

    def _read_environment(self, given: list[str]) -> None:
        for action in self._actions:
            variable = variable_of(action)
            text = os.environ.get(variable, "") if variable else ""
            if not text or any(word.partition("=")[0] in action.option_strings for word in given):
                continue
            try:
                value = self._value(action, text)
            except argparse.ArgumentError as error:
                self.exit(2, f"{self.prog}: error: {variable}: {printable(error.message)}\n")
            action.required = False
            self.set_defaults(**{action.dest: value})

    def _value(self, action: argparse.Action, text: str) -> Any:
        """Return the value that *text* stands for; several, with commas between, for what can be repeated."""
        if isinstance(action, argparse._AppendAction) or action.nargs in ("*", "+"):  # noqa: SLF001
            return [self._one_value(action, part) for part in words_of(text)]
        return self._one_value(action, text)

    def _one_value(self, action: argparse.Action, text: str) -> Any:
        value = self._get_value(action, text)
        self._check_value(action, value)
        return value

    def _get_value(self, action: argparse.Action, arg_string: str) -> Any:
        """Return the value of an argument; the error for one that is not a number is ours."""
        try:
            return super()._get_value(action, arg_string)
        except argparse.ArgumentError:
            if action.type in _EXPECTED:
                raise argparse.ArgumentError(action, f"{arg_string!r} is not {_EXPECTED[action.type]}") from None
            raise

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Refuse a value that is none of the choices, with our message."""
        if action.choices is not None and value not in action.choices:
            noun = (action.option_strings[-1].lstrip("-") if action.option_strings else str(action.metavar)).lower()
            choices = ", ".join(str(choice) for choice in action.choices)
            alike = _meant(str(value), map(str, action.choices))
            rest = f"did you mean {alike!r}?" if alike else f"there are {choices}"
            raise argparse.ArgumentError(action, f"no {noun} {value!r}; {rest}")

    def _meant_option(self, unknown: list[str]) -> str:
        """Return the option that is most similar to the first unknown one, as the end of a message."""
        wanted = next((word.partition("=")[0] for word in unknown if word.startswith("--")), "")
        alike = _meant(wanted, (name for action in self._actions for name in action.option_strings))
        return f"; did you mean {alike}?" if wanted and alike else ""


def words_of(text: str) -> list[str]:
    """Return the values of a variable, which has commas between them."""
    return [part.strip() for part in text.split(",") if part.strip()]


def _meant(wanted: str, known: Iterable[str]) -> str | None:
    # difflib is slow to load, and needed for mistakes only.
    from hmrsim.diagnostics import meant  # noqa: PLC0415

    return meant(wanted, known)


def variable_of(action: argparse.Action) -> str:
    """Return the variable that stands for an option; empty if none does."""
    names = [name for name in action.option_strings if name.startswith("--")]
    if not names or action.nargs == 0 or not _OF_ONE_RUN.isdisjoint(names):
        return ""
    return f"HMRSIM_{names[0][2:].replace('-', '_').upper()}"


@dataclass(frozen=True)
class Later:
    """A function that is imported when it is called: no ``--help`` waits for what a command needs to do its work."""

    module: str
    name: str

    def loaded(self) -> Callable[..., Any]:
        """Return the function itself."""
        function: Callable[..., Any] = getattr(importlib.import_module(self.module), self.name)
        return function

    def __call__(self, *args: Any) -> Any:
        """Return what the function returns."""
        return self.loaded()(*args)


class LazyParser(CommandParser):
    """A parser that gets its arguments when its command is the one asked for.

    Most commands load Zenoh and pydantic, which takes longer than ``--help`` of the program may.

    Args:
        module: Has a function *configure*, which adds arguments to the parser; empty for none.
    """

    def __init__(self, *, module: str = "", **options: Any) -> None:
        super().__init__(**options)
        self._module = module

    def load(self) -> None:
        """Let the command's module add its arguments, once."""
        if self._module:
            module = importlib.import_module(self._module)
            self._module = ""
            module.configure(self)

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> tuple[Any, list[str]]:
        """Parse, after the command's module has added its arguments."""
        self.load()
        return super().parse_known_args(args, namespace)

    def _print_message(self, message: str, file: Any = None) -> None:
        """Print help, and let an error through that argparse would swallow: the help could not be printed."""
        if file is sys.stdout:
            file.write(message)
        else:
            super()._print_message(message, file)


def add_commands(parser: LazyParser, commands: Mapping[str, str], modules: str, **options: Any) -> None:
    """Give a parser commands, each of which has its arguments from a module that is loaded when it is asked for.

    *commands* says what ``--help`` says of each, *modules* what the names of their modules begin with.
    """
    parsers = parser.add_subparsers(metavar="COMMAND", required=True, **options)
    words = os.environ.get("COMP_LINE", "").split() if "_ARGCOMPLETE" in os.environ else ()
    for name, summary in commands.items():
        command = parsers.add_parser(name, help=summary, module=f"{modules}{name}")
        if name in words:
            command.load()


def run_program(program: str, run: Callable[[], int]) -> int:
    """Return a program's exit code, also when its output can't be written or Ctrl-C ends it."""
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
    """Let go of what could not be written: Python would complain once more when it flushes at its end."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def autocomplete(parser: argparse.ArgumentParser, completers: str) -> None:
    """Answer the shell and end the process, if it is a shell that asks for completions; else do nothing.

    Args:
        parser: Of the program, with the arguments of all commands that are on the line.
        completers: A module whose COMPLETERS complete the positional arguments whose metavar is the key, or any
            argument whose metavar stands behind the command in the key, such as ``"hmrsim topic echo NAME"``.
    """
    if "_ARGCOMPLETE" not in os.environ:
        return
    # Takes 20 ms to load, which no other command line needs.
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
            action.completer = known  # type: ignore[attr-defined]  # argcomplete's way of telling
