"""The world of a trial, as a file of an experiment or a check names it, or as a caller passes it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hmrsim.world.model import World
from hmrsim.world.overlays.overlay import overlay_of
from hmrsim.world_checks import load_world
from hmrsim.world_checks.loading import world_of

if TYPE_CHECKING:
    from hmrsim.world.overlays.overlay import Overlay

AnyWorld = str | Path | Mapping[str, Any] | World
"""A world: the name of a shipped world, the path of a file, plain values, or a loaded world."""


def read_world(world: AnyWorld, changes: Mapping[str, Any] | None = None, overlays: Sequence[Overlay] = ()) -> World:
    """Return a world with changes.

    Args:
        world: The world.
        changes: Changes to the world, by path, as with ``--overlay``.
        overlays: Overlays to apply after the changes.

    Raises:
        WorldError: The world is invalid; it has all errors.
        ValueError: There are changes to a loaded world.
    """
    overlays = [*([overlay_of(changes, "changes")] if changes else []), *overlays]
    if isinstance(world, World):
        if overlays:
            raise ValueError("a loaded world can't be changed; pass the changes with its file or its plain values")
        return world
    if isinstance(world, Mapping):
        return world_of(dict(world), "world", overlays)
    return load_world(world, overlays=overlays).world


def source_of(world: str, folder: Path) -> str:
    """Return the path of a world's file, relative to the file that names it, or the name of a shipped world."""
    beside = folder / world
    return str(beside) if beside.is_file() or Path(world).suffix else world
