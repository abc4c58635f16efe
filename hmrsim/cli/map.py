"""``hmrsim map``: what is wrong with a world file."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Final

from hmrsim.cli.exits import ExitCode
from hmrsim.cli.output import show, show_json
from hmrsim.cli.problems import line_of
from hmrsim.errors import WorldError
from hmrsim.world import load_world
from hmrsim.world.files import find
from hmrsim.world.includes import read_document

if TYPE_CHECKING:
    import argparse
    from collections.abc import Sequence

    from hmrsim.errors import Problem

_EXAMPLES: Final = """\
examples:
  hmrsim map validate hospital
  hmrsim map validate my_world.yaml && hmrsim run my_world.yaml"""

_VALIDATE_EXAMPLES: Final = """\
exit codes: 0 no errors, maybe warnings; 1 errors; 2 the file can't be read at all

examples:
  hmrsim map validate my_world.yaml
  hmrsim map validate my_world.yaml --json | jq -r '.[].message'"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim map``."""
    parser.description = "Look at world files."
    parser.epilog = _EXAMPLES
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    validate = commands.add_parser(
        "validate",
        help="list everything that is wrong with a world file",
        description="List everything that is wrong with a world file, and what looks odd.",
        epilog=_VALIDATE_EXAMPLES,
    )
    validate.add_argument("file", metavar="FILE", help="a file of any format, or the name of a shipped world")
    validate.add_argument("--json", action="store_true", help="print one JSON list")
    validate.set_defaults(function=_validate)


def _validate(args: argparse.Namespace) -> int:
    try:
        read_document(find(args.file), args.file)
    except WorldError as error:
        _report(error.problems, as_json=args.json)
        return ExitCode.WRONG_USE
    try:
        problems, code = load_world(args.file).warnings, ExitCode.DONE
    except WorldError as error:
        problems, code = error.problems, ExitCode.FAILED
    _report(problems, as_json=args.json)
    return code


def _report(problems: Sequence[Problem], *, as_json: bool) -> None:
    if as_json:
        show_json([_plain(problem) for problem in problems])
        return
    for problem in problems:
        show(line_of(problem))
    errors = sum(problem.severity == "error" for problem in problems)
    show(f"{_counted(errors, 'error')}, {_counted(len(problems) - errors, 'warning')}")


def _plain(problem: Problem) -> dict[str, object]:
    """Return a problem as JSON values; what JSON can't hold is shown as Python does."""
    value = problem.value
    finite = not isinstance(value, float) or value - value == 0
    plain = isinstance(value, (str, int, float, bool, type(None))) and finite
    return {**asdict(problem), "value": value if plain else repr(value)}


def _counted(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"
