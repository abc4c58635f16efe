"""Analysis of a map for its designers: bottlenecks, unreachable places, trips, and where traffic concentrates.

All but the trips work on `World.graph`, or on a copy of it that was changed to ask what would be. `hmrsim map info`
prints the answers, and ``hmrsim map render --bottlenecks`` draws them; a simulation needs none of this. Beside
`World.graph` it is the only part of hmrsim that imports networkx.
"""

from __future__ import annotations

from hmrsim.topology.bottlenecks import Bottleneck, Bottlenecks, Side, bottlenecks
from hmrsim.topology.trips import (
    Concentration,
    Reach,
    Trip,
    Trips,
    concentration,
    parts,
    reach,
    seconds_at,
    speeds_of,
    trips,
)

__all__ = [
    "Bottleneck",
    "Bottlenecks",
    "Concentration",
    "Reach",
    "Side",
    "Trip",
    "Trips",
    "bottlenecks",
    "concentration",
    "parts",
    "reach",
    "seconds_at",
    "speeds_of",
    "trips",
]
