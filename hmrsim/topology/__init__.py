"""What planners ask of a map; a simulation needs none of it.

All of it works on `World.graph`, or on a copy of it that was changed to ask what would be.
"""

from __future__ import annotations

from hmrsim.topology.connectivity import Reach, parts, reach

__all__ = ["Reach", "parts", "reach"]
