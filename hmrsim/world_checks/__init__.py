"""Loading and validating worlds, and the checks that need more than one field.

Commands use it for files, and services for worlds that clients send.
"""

from __future__ import annotations

from hmrsim.world_checks.loading import LoadedWorld, load_world, world_hash

__all__ = ["LoadedWorld", "load_world", "world_hash"]
