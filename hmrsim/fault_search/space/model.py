"""The model of what can happen, as the file of a check says it."""

from __future__ import annotations

from typing import Annotated, Any, Final, Literal

from pydantic import Field

from hmrsim.experiments.file.model import Seconds
from hmrsim.trials.model import Part

Family = Literal["faults", "changes", "disturbances"]

OPT_IN: Final = ("item_lost", "second_controller", "simulation_reset")
"""What happens only where a check asks for it: few controllers promise to bear it, or none can."""


class Space(Part):
    """The injections to search; by default everything that can happen to the robots of the world.

    Attributes:
        families: Faults, changes of the world, disturbances of the wire and the controller.
        only: The kinds that happen; None for all.
        without: Kinds that do not happen.
        also: Kinds that happen only if they are asked for: ``item_lost``, ``second_controller``, ``simulation_reset``.
        spare: Robots, doors, docks and items to which nothing happens.
        at_most: How many injections one schedule has.
        durations: Seconds that injections last.
        weights: How often a kind is tried, beside 1 for others.
        further: Custom injections; a list of values stands for each of them, and a robot ``*`` for each robot.
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
