"""Loading and validating worlds, and the checks that need more than one field.

Every command that reads a world uses it, and so do services for worlds that clients send.
"""

from __future__ import annotations

from hmrsim.world_checks.checks import check_world
from hmrsim.world_checks.loading import LoadedWorld, load_world, world_hash

__all__ = ["LoadedWorld", "check_world", "load_world", "world_hash"]
