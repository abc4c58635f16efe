"""``hmrsim map validate``: everything that is wrong with a world file."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Final

from hmrsim.cli.exits import ExitCode
from hmrsim.cli.output import show, show_json
from hmrsim.cli.problems import line_of
from hmrsim.cli.world_options import add_world_options
from hmrsim.cli.worlds import read_world
from hmrsim.errors import WorldError
from hmrsim.program.command_line import ENVIRONMENT
from hmrsim.settings.arguments import read_settings
from hmrsim.settings.world import WorldSettings
from hmrsim.world.files import find
from hmrsim.world.includes import read_document
from hmrsim.world.options import ReadOptions

if TYPE_CHECKING:
    import argparse
    from collections.abc import Sequence

    from hmrsim.errors import Problem

_EXAMPLES: Final = f"""\
exit codes: 0 no errors, maybe warnings; 1 errors; 2 the file, or an option, can't be read

examples:
  hmrsim map validate my_world.yaml
  hmrsim map validate my_world.yaml --json | jq -r '.[].message'

{ENVIRONMENT}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim map validate``."""
    parser.description = "List everything that is wrong with a world file, and what looks odd."
    parser.epilog = _EXAMPLES
    add_world_options(parser, argument="file")
    parser.add_argument("--json", action="store_true", help="print one JSON list")
    parser.set_defaults(function=_validate)


def _validate(args: argparse.Namespace) -> int:
    try:
        problems, code = read_world(args, argument="file").warnings, ExitCode.DONE
    except WorldError as error:
        misused = any(_is_wrong_use(problem) for problem in error.problems) or not _readable(args)
        problems, code = error.problems, ExitCode.WRONG_USE if misused else ExitCode.FAILED
    _report(problems, as_json=args.json)
    return code


def _is_wrong_use(problem: Problem) -> bool:
    """Return whether an option can't be read, as opposed to one that does not apply to the file."""
    return problem.file.startswith("--") and not problem.path


def _readable(args: argparse.Namespace) -> bool:
    """Return whether a file exists and has a known format, whatever its content."""
    try:
        read_document(find(args.file), args.file, ReadOptions(page=read_settings(args, WorldSettings).page))
    except WorldError:
        return False
    return True


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
