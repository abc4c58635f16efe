"""What ``hmrsim map validate`` does: it reads a world file, and lists what is wrong with it."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING

from hmrsim.cli.exits import ExitCode
from hmrsim.cli.output import show, show_json
from hmrsim.cli.worlds import line_of, policy_line, read_world
from hmrsim.errors import WorldError
from hmrsim.settings.arguments import read_settings
from hmrsim.settings.run import WorldSettings
from hmrsim.world.files import find
from hmrsim.world.includes import read_document
from hmrsim.world.options import ReadOptions
from hmrsim.world_checks.lanes import check_crossings
from hmrsim.world_checks.obstructions import check_obstructions

if TYPE_CHECKING:
    from hmrsim.diagnostics import Finding
    from hmrsim.errors import Problem
    from hmrsim.world import World


def validate(args: argparse.Namespace) -> int:
    """List the problems of the file that the options name; return the exit code."""
    try:
        loaded = read_world(args, argument="file", further=_further(traffic=args.traffic))
        problems, policy, code = loaded.warnings, policy_line(loaded.world), ExitCode.DONE
    except WorldError as error:
        misused = any(_is_wrong_use(problem) for problem in error.problems) or not _readable(args)
        problems, policy, code = error.problems, "", ExitCode.WRONG_USE if misused else ExitCode.FAILED
    _report(problems, policy, as_json=args.json)
    return code


def _further(*, traffic: bool) -> list[Callable[[World], Iterable[Finding]]]:
    """Return the checks beside those that every command makes."""
    if not traffic:
        return [check_crossings]
    from hmrsim.world_checks.forecast import forecast  # noqa: PLC0415 - it loads networkx

    return [check_crossings, check_obstructions, forecast]


def _is_wrong_use(problem: Problem) -> bool:
    """Return whether it is an option that can't be read, as opposed to one that does not go with the file."""
    return problem.file.startswith("--") and not problem.path


def _readable(args: argparse.Namespace) -> bool:
    """Return whether a file is there and of a known format, whatever it says."""
    try:
        read_document(find(args.file), args.file, ReadOptions(page=read_settings(args, WorldSettings).page))
    except WorldError:
        return False
    return True


def _report(problems: Sequence[Problem], policy: str, *, as_json: bool) -> None:
    if as_json:
        show_json([_plain(problem) for problem in problems])
        return
    for problem in problems:
        show(line_of(problem))
    if policy:
        show(policy)
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
