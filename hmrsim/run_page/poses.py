"""The poses of a robot over time, as key frames between which it moves evenly."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Final, NamedTuple

from hmrsim.history.motion import Motion

if TYPE_CHECKING:
    from hmrsim.events.robots import MotionBegan
    from hmrsim.geometry import Point

_SPLITS: Final = 4
"""How often a stretch of changing speed is halved, at most."""
_TURN: Final = 0.01
"""Radians that do not count as a turn."""


class KeyFrame(NamedTuple):
    """A pose at a time in nanoseconds; x and y in the world's unit, yaw in radians, which may exceed a full turn."""

    at: int
    x: float
    y: float
    yaw: float


class Poses:
    """The poses of one robot.

    Args:
        tolerance: How far off the real position an interpolated one may be, in the world's unit.

    Attributes:
        frames: In order of time; two at the same time are a jump.
    """

    def __init__(self, tolerance: float) -> None:
        self.frames: list[KeyFrame] = []
        self._tolerance = tolerance

    def put(self, at: int, x: float, y: float, yaw: float | None = None) -> None:
        """Put the robot somewhere, where it stays until it moves; without *yaw* it keeps its direction."""
        self.halt(at)
        last = self.frames[-1] if self.frames else KeyFrame(at, math.inf, math.inf, 0.0)
        yaw = last.yaw if yaw is None else yaw
        if math.dist((x, y), last[1:3]) > self._tolerance or abs(yaw - last.yaw) > _TURN:
            self._hold(at)
            self.frames.append(KeyFrame(at, x, y, yaw))

    def move(self, at: int, event: MotionBegan) -> None:
        """Record a motion and those that follow it, which end early if another event comes first."""
        self.put(at, *event.from_)
        self._hold(at)
        segments = [event, *(type(event).from_json({**fields, "robot": event.robot}) for fields in event.then)]
        for motion, segment in zip(Motion.all_of(at, event), segments, strict=True):
            (x, y, yaw), (to_x, to_y, to_yaw) = segment.from_, segment.to
            if segment.turned is not None:
                to_yaw = yaw + segment.turned
            if segment.ride:
                self.frames.append(KeyFrame(motion.until, x, y, yaw))
            elif motion.length:
                for then in _moments(motion, motion.began, motion.until, self._tolerance, _SPLITS):
                    share = motion.driven(then) / motion.length
                    self.frames.append(KeyFrame(then, x + (to_x - x) * share, y + (to_y - y) * share, yaw))
            self.frames.append(KeyFrame(motion.until, to_x, to_y, to_yaw))

    def halt(self, at: int, where: Point | None = None) -> None:
        """End the current motion, at a point if it is given."""
        later = None
        while self.frames and self.frames[-1].at > at:
            later = self.frames.pop()
        if later is not None and self.frames:
            last = self.frames[-1]
            share = (at - last.at) / (later.at - last.at) if later.at > last.at else 0.0
            between = (a + (b - a) * share for a, b in zip(last[1:], later[1:], strict=True))
            self.frames.append(KeyFrame(at, *between))
        if where is not None and self.frames and self.frames[-1][1:3] != where:
            self.frames.append(KeyFrame(at, *where, self.frames[-1].yaw))

    def _hold(self, at: int) -> None:
        """Stay at the last pose until some time."""
        if self.frames and self.frames[-1].at < at:
            self.frames.append(self.frames[-1]._replace(at=at))

    def encoded(self, place: Callable[[Point], Point], *, turns: float) -> list[int]:
        """Return the frames as differences of microseconds, tenths of the units of *place*, and degrees.

        Args:
            place: Returns the point of a picture for one of the world.
            turns: 1 if the picture's angles have the sign of the world's, -1 otherwise.
        """
        values, before = [], (0, 0, 0, 0)
        for frame in self.frames:
            x, y = place((frame.x, frame.y))
            now = (
                round(frame.at / 1000),
                round(x * 10),
                round(y * 10),
                round(math.degrees(frame.yaw) * turns),
            )
            values += [a - b for a, b in zip(now, before, strict=True)]
            before = now
        return values


def _moments(motion: Motion, began: int, until: int, tolerance: float, splits: int) -> Iterator[int]:
    """Yield the times within a stretch between which the speed is constant, within the tolerance."""
    first, last, middle = motion.driven(began), motion.driven(until), (began + until) // 2
    off = (
        abs(motion.driven(began + (until - began) * i // 4) - first - (last - first) * i / 4) > tolerance
        for i in (1, 2, 3)
    )
    if motion.profile is None or not splits or not any(off):
        return
    yield from _moments(motion, began, middle, tolerance, splits - 1)
    yield middle
    yield from _moments(motion, middle, until, tolerance, splits - 1)
