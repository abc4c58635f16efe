"""The spawnables: robots of the world's types, and items."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from hmrsim.world.model import BUILT_IN_TYPES

if TYPE_CHECKING:
    from hmrsim.world.model import World

ITEM = "item"
ROBOT = "robot_type:"
LIKE = "item:"


@dataclass(frozen=True)
class Kind:
    """A spawnable.

    Attributes:
        stem: The prefix of generated names.
        robot_type: Its type, if it is a robot.
        weight: If it is an item; in kg.
    """

    uri: str
    description: str
    stem: str
    robot_type: str | None = None
    weight: float = 0.0


def kinds(world: World) -> Iterator[Kind]:
    """Yield the spawnables of a world: its robots' types, those built in, and items such as it has."""
    for name, kind in (
        world.robot_types | {k: v for k, v in BUILT_IN_TYPES.items() if k not in world.robot_types}
    ).items():
        carried = ", ".join(sorted(kind.components)) or "nothing"
        yield Kind(f"{ROBOT}{name}", f"robot of type {name}, which carries {carried}", name, robot_type=name)
    yield Kind(ITEM, "item without weight", ITEM)
    for name, item in world.items.items():
        yield Kind(f"{LIKE}{name}", f"item like {name}, of {item.weight:g} kg", name, weight=item.weight)
