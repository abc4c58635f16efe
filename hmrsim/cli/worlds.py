"""The world that a command line names, and its problems."""

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
from hmrsim.world.options import renames
from hmrsim.world.overlays.overlay import overlays_of
from hmrsim.world_checks import load_world

if TYPE_CHECKING:
    from hmrsim.diagnostics import Finding
    from hmrsim.errors import Problem
    from hmrsim.properties import Properties
    from hmrsim.world import World
    from hmrsim.world_checks import LoadedWorld

_MEETING: Final = 2
"""Number of robots that it takes for two to meet."""


def read_world(
    args: argparse.Namespace,
    *,
    argument: str = "world",
    below: Mapping[str, Any] | None = None,
    further: Sequence[Callable[[World], Iterable[Finding]]] = (),
) -> LoadedWorld:
    """Read the world that a command line names, with its additions.

    Args:
        args: The command line.
        argument: What the world is called there.
        below: The settings of a file.
        further: Further checks, as `load_world` takes them.

    Raises:
        WorldError: It is not valid.
    """
    settings = read_settings(args, WorldSettings, below)
    options = ReadOptions(settings.page, renames(settings.rename), settings.lenient, settings.neighbours)
    return load_world(
        getattr(args, argument),
        add_robots=settings.robot,
        add_items=settings.item,
        options=options,
        overlays=overlays_of(settings.overlay, settings.set),
        further=further,
    )


class FirstFindings:
    """A check that yields the first findings of another one, and counts the rest.

    Attributes:
        left_out: How many findings the last check had beyond the first ones.
    """

    def __init__(self, check: Callable[[World], Iterable[Finding]], most: int) -> None:
        self._check = check
        self._most = most
        self.left_out = 0

    def __call__(self, world: World) -> Iterable[Finding]:
        """Yield the first findings for a world."""
        findings = [*self._check(world)]
        self.left_out = max(0, len(findings) - self._most)
        return findings[: self._most]


def show_warnings(loaded: LoadedWorld) -> None:
    """Print the warnings of a world, one a line."""
    for problem in loaded.warnings:
        warn(line_of(problem))


def policy_line(world: World) -> str:
    """Return which traffic policy is in force, and why if it is the default; "" where no two robots can meet."""
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
    """Print what should be noted of properties in their world.

    Raises:
        PropertyError: They speak of what it lacks.
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
