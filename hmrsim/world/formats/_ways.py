"""Ways from waypoint to waypoint, made into lanes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hmrsim.world.formats._part import Part
    from hmrsim.world.formats._reading import Reading


@dataclass
class _Way:
    part: Part
    limit: float | None
    capacity: int | None
    alone: bool


class Ways:
    """Ways in one direction each."""

    def __init__(self, reading: Reading) -> None:
        self._reading = reading
        self._ways: dict[tuple[str, str], _Way] = {}

    def add(
        self,
        ends: tuple[str, str],
        part: Part,
        *,
        limit: float | None = None,
        capacity: int | None = None,
        alone: bool = False,
    ) -> None:
        """Add a way; of several between the same ends the faster one counts.

        Args:
            ends: The waypoints where it begins and ends.
            part: What it is from.
            limit: The speed limit; None for none.
            capacity: How many robots may be on it; None where nothing is said of it.
            alone: Whether it is not a part of a lane that leads both ways.
        """
        way = self._ways.get(ends)
        if way is None:
            self._ways[ends] = _Way(part, limit, capacity, alone)
            return
        self._reading.leave_out("ways that were there before", part)
        if way.limit is not None:
            way.limit = None if limit is None else max(limit, way.limit)

    def lanes(self) -> list[dict[str, Any]]:
        """Return the lanes, as in a world file; two ways that are alike but for their direction make one."""
        lanes: list[dict[str, Any]] = []
        done: set[tuple[str, str]] = set()
        for (start, end), way in self._ways.items():
            if (start, end) in done:
                continue
            back = self._ways.get((end, start))
            lane: dict[str, Any] = {"from": start, "to": end}
            if back and not (way.alone or back.alone) and (way.limit, way.capacity) == (back.limit, back.capacity):
                done.add((end, start))
            else:
                lane["one_way"] = True
            if way.limit is not None:
                lane["speed_limit"] = way.limit
            if way.capacity is not None:
                lane["capacity"] = way.capacity
            self._reading.origin(("lanes", len(lanes)), way.part)
            lanes.append(lane)
        return lanes
