"""Where the items are at the end of the run without faults, with which other runs are compared."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from hmrsim.geometry import Point


class ItemEnd(NamedTuple):
    """Where an item is at the end of a run.

    Attributes:
        at: Where it lies, in the world's unit.
        carried: Whether a robot holds it.
    """

    at: Point
    carried: bool


Reference = Mapping[str, ItemEnd]
"""The items at the end of a run, by name."""


def reference_of(scene: Mapping[str, Any]) -> Reference:
    """Return the items of a scene, as `hmrsim.simulation.snapshot.scene` returns it."""
    return {
        item["name"]: ItemEnd((item["at"][0], item["at"][1]), item["carrier"] is not None) for item in scene["items"]
    }
