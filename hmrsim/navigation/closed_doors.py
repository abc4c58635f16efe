"""The doors that are closed now, each of which is a wall off the lanes."""

from __future__ import annotations

from hmrsim.geometry import Obstacles, Point


class ClosedDoors:
    """The doors that are closed; each is known by where its jambs are."""

    def __init__(self) -> None:
        self._closed: dict[tuple[Point, Point], None] = {}
        self._made: Obstacles | None = None

    def set(self, at: tuple[Point, Point], *, is_open: bool) -> None:
        """Record that a door is open or closed now."""
        if is_open:
            self._closed.pop(at, None)
        else:
            self._closed[at] = None
        self._made = None

    @property
    def obstacles(self) -> Obstacles:
        """The same as obstacles; made when they are asked for, as many may close at one instant."""
        if self._made is None:
            self._made = Obstacles(self._closed, ())
        return self._made
