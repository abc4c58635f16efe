"""The model of a world, the formats that it is read from, and the files that are shipped.

Everything that reads or writes worlds uses it; `hmrsim.world_checks` checks whether a world can run.
"""

from __future__ import annotations

from hmrsim.world.files import ReadOptions
from hmrsim.world.model import World

__all__ = ["ReadOptions", "World"]
