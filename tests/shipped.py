"""The shipped worlds, each loaded once for all tests of a process."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

from hmrsim.world_checks import load_world

if TYPE_CHECKING:
    from hmrsim.world_checks.loading import LoadedWorld


@cache
def shipped(name: str) -> LoadedWorld:
    """Return a shipped world by its name; it is shared, and its models are frozen."""
    return load_world(name)
