"""The colours and shapes of pictures, page and report, which are in one file that all of them read."""

from __future__ import annotations

import json
from importlib.resources import files
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from hmrsim.world_checks.resolved import type_order

if TYPE_CHECKING:
    from hmrsim.world.model import World

PALETTE: Final[dict[str, Any]] = json.loads(files("hmrsim.drawing").joinpath("palette.json").read_text("utf-8"))
"""Colours by what they stand for, by theme, and from little to much; those of types, states and statuses in both."""

THEMES: Final = ("light", "dark")


BODIES: Final[dict[str, Any]] = PALETTE["bodies"]
"""Shapes of robots, as paths of SVG in the unit circle, which look along +x."""


class Look(NamedTuple):
    """How robots of a type look: the colour of their bodies, and their shape as a path."""

    colour: str
    shape: str


def type_looks(world: World) -> dict[str, Look]:
    """Return the look of each type of robot that the world has robots of, in the order of its robots."""
    used = {robot.type for robot in world.robots.values()}
    colours, shapes = PALETTE["types"], BODIES["types"]
    return {
        name: Look(colours[number % len(colours)], shapes[number % len(shapes)])
        for number, name in enumerate(type_order(world))
        if name in used
    }
