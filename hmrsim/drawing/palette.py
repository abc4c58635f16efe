"""The colours of pictures, page and report, which are in one file that all of them read."""

from __future__ import annotations

import json
from importlib.resources import files
from typing import TYPE_CHECKING, Any, Final

from hmrsim.world_checks.resolved import type_order

if TYPE_CHECKING:
    from hmrsim.world.model import World

PALETTE: Final[dict[str, Any]] = json.loads(files("hmrsim.drawing").joinpath("palette.json").read_text("utf-8"))
"""Colours by what they stand for, by theme, and from little to much; those of types, states and statuses in both."""

THEMES: Final = ("light", "dark")


def type_colours(world: World) -> dict[str, str]:
    """Return the colour of each type of robot that the world has robots of, in the order of its robots."""
    used = {robot.type for robot in world.robots.values()}
    colours = PALETTE["types"]
    return {name: colours[number % len(colours)] for number, name in enumerate(type_order(world)) if name in used}
