"""The model of a check's file."""

from __future__ import annotations

import re
from typing import Annotated, Any, Final, Literal

from pydantic import BeforeValidator, Field

from hmrsim.experiments.file.model import Count, Memory, Seconds
from hmrsim.fault_search.space.model import Space
from hmrsim.trials.model import Controller, Part

_BUDGET: Final = re.compile(r"(\d+(?:\.\d+)?) ?(s|min|m|h)?")
_UNITS: Final = {None: 1.0, "s": 1.0, "min": 60.0, "m": 60.0, "h": 3600.0}


def seconds_of(value: Any) -> Any:
    """Return the wall seconds of a text such as ``90 s``, ``10m`` or ``1 h``; anything else as it is.

    Raises:
        ValueError: A text is no time.
    """
    if not isinstance(value, str):
        return float(value) if type(value) is int else value
    match = _BUDGET.fullmatch(value.strip())
    if match is None:
        raise ValueError(f"expected a time such as 90s, 10m or 1h, got {value!r}")
    return float(match[1]) * _UNITS[match[2]]


class Budget(Part):
    """How long to search.

    Attributes:
        time: Seconds of the wall's clock; in a file also ``90 s``, ``10m`` or ``1 h``.
        runs: Runs after which the search ends in any case; with it alone two searches are the same.
    """

    time: Annotated[float, BeforeValidator(seconds_of), Field(strict=True, gt=0, le=1e7)] = 600.0
    runs: Count | None = None


class Limits(Part):
    """What a run may take.

    Attributes:
        simulated: Seconds of simulated time, by which the controller has to end; None for ten times what it takes
            without faults, and ten minutes more.
        wall: Seconds of the wall's clock in which it waits: in which nothing of it computes, or could.
        processor: Seconds of processor time; as many as *wall* if left out.
        memory: Bytes that it may take beyond what its worker has; in a file also 500 MB or 1 GB.
    """

    simulated: Seconds | None = None
    wall: Seconds = 20.0
    processor: Seconds | None = None
    memory: Memory | None = None


def _budget(value: Any) -> Any:
    return {"time": value} if isinstance(value, (str, int, float)) and not isinstance(value, bool) else value


class CheckFile(Part):
    """A check: a world, a controller, the properties that have to hold, and what can go wrong."""

    name: Annotated[str, Field(min_length=1, max_length=100)] | None = None
    world: str | dict[str, Any] = Field(description="A world file, the name of a shipped world, or a world itself.")
    controller: Controller
    overlay: dict[str, Any] = Field(default={}, description="Laid over the world.")
    properties: str | dict[str, Any] | None = Field(
        default=None, description="A file of properties, or what one says; without it the built-in ones alone."
    )
    space: Space = Space()
    limits: Limits = Limits()
    budget: Annotated[Budget, BeforeValidator(_budget)] = Budget()
    seed: Annotated[int, Field(strict=True)] = 0
    world_seed: Annotated[int, Field(strict=True)] | None = Field(
        default=None, description="The seed of the runs; the world's own if left out."
    )


class Failed(Part):
    """How a run has failed.

    Attributes:
        property: The property that was violated.
        reason: Why, without times and names.
    """

    property: str
    reason: str


class ReproFile(CheckFile):
    """A failure that was found: a check with the schedule that shows it."""

    repro: Literal[1] = Field(description="The version of the format.")
    schedule: tuple[dict[str, Any], ...] = Field(description="What goes wrong: faults, changes and disturbances.")
    failure: Failed
    folder: str = Field(default=".", description="Where the controller's files are, from the folder of this file.")
    trace: str = Field(default="", description="SHA-256 of the run's trace; empty if it is not known.")
