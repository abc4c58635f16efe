"""The models of check files and reproducer files."""

from __future__ import annotations

import re
from typing import Annotated, Any, Final, Literal

from pydantic import BeforeValidator, Field

from hmrsim.trials.model import Controller, Count, Limits, Part, Seconds

Family = Literal["faults", "changes", "disturbances"]

OPT_IN: Final = ("item_lost", "second_controller", "simulation_reset")
"""The kinds that happen only if a check asks for them, since few controllers can handle them."""


class Space(Part):
    """The space of injections to search; by default everything that can happen to the robots of the world.

    Attributes:
        families: Faults, changes of the world, and disturbances of the connection and the controller.
        only: The kinds to try; None for all.
        without: Kinds to leave out.
        also: Kinds to add that are left out by default: ``item_lost``, ``second_controller``, ``simulation_reset``.
        spare: Robots, doors, docks and items to leave alone.
        at_most: The maximum number of injections in a schedule.
        durations: The durations of injections in seconds.
        weights: The frequency of a kind, relative to 1.
        further: Custom injections; a list of values stands for each value, and a robot ``*`` for each robot.
    """

    families: tuple[Family, ...] = ("faults", "changes", "disturbances")
    only: tuple[str, ...] | None = None
    without: tuple[str, ...] = ()
    also: tuple[str, ...] = ()
    spare: tuple[str, ...] = ()
    at_most: Annotated[int, Field(strict=True, ge=1, le=100)] = 3
    durations: Annotated[tuple[Seconds, ...], Field(min_length=1)] = (5.0, 30.0)
    weights: dict[str, Annotated[float, Field(strict=True, gt=0, le=1e6)]] = Field(default={})
    further: tuple[dict[str, Any], ...] = ()


_BUDGET: Final = re.compile(r"(\d+(?:\.\d+)?) ?(s|min|m|h)?")
_UNITS: Final = {None: 1.0, "s": 1.0, "min": 60.0, "m": 60.0, "h": 3600.0}


def seconds_of(value: Any) -> Any:
    """Return the wall seconds of a text such as ``90 s``, ``10m`` or ``1 h``; other values unchanged.

    Raises:
        ValueError: The text is not a time.
    """
    if not isinstance(value, str):
        return float(value) if type(value) is int else value
    match = _BUDGET.fullmatch(value.strip())
    if match is None:
        raise ValueError(f"expected a time such as 90s, 10m or 1h, got {value!r}")
    return float(match[1]) * _UNITS[match[2]]


class Budget(Part):
    """The budget of a search.

    Attributes:
        time: Wall seconds; in a file also ``90 s``, ``10m`` or ``1 h``.
        runs: The number of runs; searches with only this limit are reproducible.
    """

    time: Annotated[float, BeforeValidator(seconds_of), Field(strict=True, gt=0, le=1e7)] = 600.0
    runs: Count | None = None


def _budget(value: Any) -> Any:
    """Return a budget for a bare time; other values unchanged."""
    return {"time": value} if isinstance(value, (str, int, float)) and not isinstance(value, bool) else value


class CheckFile(Part):
    """The file of a check: a world, a controller, the properties that must hold, and the space to search."""

    name: Annotated[str, Field(min_length=1, max_length=100)] | None = None
    world: str | dict[str, Any] = Field(description="A world file, the name of a shipped world, or a world itself.")
    controller: Controller
    overlay: dict[str, Any] = Field(default={}, description="Changes to the world, as in an overlay file.")
    properties: str | dict[str, Any] | None = Field(
        default=None, description="A file of properties, or its content; by default only the built-in ones."
    )
    space: Space = Space()
    limits: Limits = Limits()
    budget: Annotated[Budget, BeforeValidator(_budget)] = Budget()
    seed: Annotated[int, Field(strict=True)] = 0
    world_seed: Annotated[int, Field(strict=True)] | None = Field(
        default=None, description="The seed of the runs; by default the world's own."
    )


class Failed(Part):
    """The failure of a run.

    Attributes:
        property: The property that was violated.
        reason: The reason, without times and names.
    """

    property: str
    reason: str


class ReproFile(CheckFile):
    """The file of a failure: a check with the schedule that causes it."""

    repro: Literal[1] = Field(description="The version of the format.")
    schedule: tuple[dict[str, Any], ...] = Field(description="The injections: faults, changes and disturbances.")
    failure: Failed
    folder: str = Field(
        default=".", description="The folder of the controller's files, relative to the folder of this file."
    )
    trace: str = Field(default="", description="SHA-256 of the run's trace; empty if unknown.")
