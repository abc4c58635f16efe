"""Worlds: reading them, checking them, and what they are made of."""

from __future__ import annotations

from hmrsim.world.checks import check_world
from hmrsim.world.loading import LoadedWorld, load_world, world_hash
from hmrsim.world.model import World
from hmrsim.world.options import ReadOptions

__all__ = ["LoadedWorld", "ReadOptions", "World", "check_world", "load_world", "world_hash"]
