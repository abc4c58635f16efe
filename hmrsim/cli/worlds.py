"""The world on a command line, and its problems."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from hmrsim.cli.output import warn
from hmrsim.errors import PropertyError
from hmrsim.settings.arguments import read_settings
from hmrsim.settings.run import WorldSettings
from hmrsim.world import ReadOptions
from hmrsim.world.files import renames
from hmrsim.world.overlays.overlay import overlays_of
from hmrsim.world_checks import load_world

if TYPE_CHECKING:
    from hmrsim.diagnostics import Finding
    from hmrsim.errors import Problem
    from hmrsim.properties import Properties
    from hmrsim.world import World
    from hmrsim.world_checks import LoadedWorld

_MEETING: Final = 2
"""Number of robots from which two can meet."""


def read_world(
    args: argparse.Namespace,
    *,
    below: Mapping[str, Any] | None = None,
    further: Sequence[Callable[[World], Iterable[Finding]]] = (),
) -> LoadedWorld:
    """Read the world on a command line, with the options that change it.

    Args:
        args: The command line.
        below: The settings of a file, which options override.
        further: Further checks, as for `load_world`.

    Raises:
        WorldError: The world is not valid.
    """
    settings = read_settings(args, WorldSettings, below)
    options = ReadOptions(settings.page, renames(settings.rename), settings.lenient, settings.neighbours)
    return load_world(
        args.world,
        add_robots=settings.robot,
        add_items=settings.item,
        options=options,
        overlays=overlays_of(settings.overlay, settings.set),
        further=further,
    )


def show_warnings(loaded: LoadedWorld) -> None:
    """Print the warnings of a world, one per line."""
    for problem in loaded.warnings:
        warn(line_of(problem))


def policy_line(world: World) -> str:
    """Return a line about the traffic policy, and why it is the default; empty if no two robots can meet."""
    if sum(not world.robot_type(robot).base.flies for robot in world.robots.values()) < _MEETING:
        return ""
    bodies = len(world.bodies)
    if world.traffic.policy:
        reason = ""
    elif bodies < _MEETING:
        reason = " (default: robots pass through each other; to change that, give two a radius or set traffic.policy)"
    else:
        reason = f" (default: {bodies} robots have a radius)"
    return f"traffic policy: {world.policy}{reason}"


def show_findings(properties: Properties, findings: Sequence[Finding]) -> None:
    """Print warnings about properties in a world.

    Raises:
        PropertyError: The properties refer to something that the world lacks.
    """
    problems = properties.problems(findings)
    errors = [problem for problem in problems if problem.severity == "error"]
    if errors:
        raise PropertyError(errors)
    for problem in problems:
        warn(line_of(problem))


def line_of(problem: Problem) -> str:
    """Return ``file:line: path: message``, with ``warning:`` after the place of a warning."""
    if problem.severity == "error":
        return str(problem)
    place = replace(problem, path="", message="")
    return f"{place}: {problem.severity}: {replace(problem, file='', line=None)}"
