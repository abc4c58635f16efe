"""The motions of robots, and the times at which a robot enters and leaves the circle around a place."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from hmrsim.events.robots import MotionBegan
from hmrsim.geometry import distance
from hmrsim.history.occurrence import Misfit, number, text
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.navigation.motion import Trapezoid

if TYPE_CHECKING:
    from hmrsim.geometry import Point

INSTANT: Final = 5
"""Nanoseconds within which two times count as equal, since stamps are rounded."""

_MAX_SECONDS: Final = 1e9
"""The maximum duration of a segment, in seconds."""


def motion_in(robot: Mapping[str, Any], at: int, offset: int) -> tuple[int, MotionBegan] | None:
    """Return the beginning of a robot's motion in a scene, and the event of that motion; None if the robot stands.

    *offset* is that of stamps at the time of the scene (`hmrsim.history.timeline.Timeline`).

    Raises:
        ValueError: The motion is malformed.
    """
    motion = robot.get("motion")
    if not isinstance(motion, dict):
        return None
    began = at if motion.get("began") is None else round(number(motion, "began") * NANOSECONDS) + offset
    return min(began, at), MotionBegan.from_json({**motion, "robot": text(robot, "name")})


@dataclass(slots=True)
class Motion:
    """A straight segment, a turn or a ride in a lift; times in nanoseconds.

    Attributes:
        length: The length of the segment; 0 for a turn or a ride.
        lane: The waypoints of the lane that is driven; None beside the lanes.
        profile: The speed over time; None for a constant speed.
        behind: The distance of the profile that was driven before this segment.
    """

    began: int
    until: int
    start: Point
    end: Point
    length: float
    lane: tuple[str, str] | None
    profile: Trapezoid | None
    behind: float

    @classmethod
    def all_of(cls, at: int, event: MotionBegan) -> list[Motion]:
        """Return the segment that an event begins, and those that follow it.

        Raises:
            ValueError: The event is malformed.
        """
        events = [event, *(type(event).from_json({**fields, "robot": event.robot}) for fields in event.then)]
        segments, seconds = [], 0.0
        for segment in events:
            segments.append(cls._of(at + round(seconds * NANOSECONDS), segment))
            seconds += segment.duration
        return segments

    @classmethod
    def _of(cls, at: int, event: MotionBegan) -> Motion:
        start, end = event.from_[:2], event.to[:2]
        if not 0 <= event.duration <= _MAX_SECONDS:
            raise Misfit("duration out of range")
        profile, behind = _profile(event.profile)
        until = at + round(event.duration * NANOSECONDS)
        length = 0.0 if event.ride or event.turned is not None else distance(start, end)
        return cls(at, until, start, end, length, event.lane, profile, behind)

    def driven(self, at: int) -> float:
        """Return the distance that has been driven on this segment at a time."""
        if at >= self.until - INSTANT:
            return self.length
        elapsed = (at - self.began) / NANOSECONDS
        if self.profile is None:
            return self.length * elapsed * NANOSECONDS / (self.until - self.began)
        before = self.profile.time(self.behind)
        return min(self.length, max(0.0, self.profile.driven(before + elapsed) - self.behind))


Span = tuple[int, int | None]
"""The times at which a robot enters and leaves a circle, in nanoseconds; None if it stays."""


def spans_near(place: Point, radius: float, motions: Iterable[Motion]) -> list[Span]:
    """Return the times that a robot spends within a radius of a place, during its motions and after the last one."""
    spans: list[list[int | None]] = []
    motion = None
    for motion in motions:
        span = _span_of_motion(place, radius, motion)
        if span is None:
            continue
        began, ended = span
        if spans and spans[-1][1] is not None and began <= spans[-1][1] + 1:
            spans[-1][1] = ended
        else:
            spans.append([began, ended])
    if motion is not None and spans and spans[-1][1] == motion.until and distance(motion.end, place) <= radius:
        spans[-1][1] = None
    elif motion is not None and not motion.length and distance(motion.end, place) <= radius:
        # A lift has brought the robot there at the end of its ride.
        spans.append([motion.until, None])
    return [(began or 0, ended) for began, ended in spans]


def closest(place: Point, motions: Iterable[Motion], until: int) -> float:
    """Return the least distance between a robot and a place during its motions, up to a time."""
    least = math.inf
    for motion in motions:
        if motion.began > until:
            break
        driven = motion.driven(until) if motion.length else 0.0
        nearest = motion.end if not motion.length and until >= motion.until else motion.start
        if driven:
            (ax, ay), (bx, by) = motion.start, motion.end
            ux, uy = (bx - ax) / motion.length, (by - ay) / motion.length
            along = min(driven, max(0.0, (place[0] - ax) * ux + (place[1] - ay) * uy))
            nearest = (ax + along * ux, ay + along * uy)
        least = min(least, distance(motion.start, place), distance(nearest, place))
    return least


def _span_of_motion(place: Point, radius: float, motion: Motion) -> tuple[int, int] | None:
    """Return when a robot enters and leaves the circle around a place during a motion; None if it stays outside."""
    if not motion.length:
        # A robot that turns or rides in a lift counts as being at the start until the end.
        return (motion.began, motion.until) if distance(motion.start, place) <= radius else None
    (ax, ay), (bx, by) = motion.start, motion.end
    ux, uy = (bx - ax) / motion.length, (by - ay) / motion.length
    dx, dy = place[0] - ax, place[1] - ay
    along = dx * ux + dy * uy
    across = dx * uy - dy * ux
    half_chord_squared = radius * radius - across * across
    if half_chord_squared < 0.0:
        return None
    half = math.sqrt(half_chord_squared)
    first, last = max(0.0, along - half), min(motion.length, along + half)
    if first > last:
        return None
    return _time_at(motion, first), _time_at(motion, last)


def _time_at(motion: Motion, driven: float) -> int:
    """Return the time at which a motion has covered a distance."""
    if driven <= 0.0:
        return motion.began
    if driven >= motion.length:
        return motion.until
    if motion.profile is None:
        return motion.began + round((motion.until - motion.began) * driven / motion.length)
    seconds = motion.profile.time(motion.behind + driven) - motion.profile.time(motion.behind)
    return min(motion.until, motion.began + round(seconds * NANOSECONDS))


def _profile(profile: tuple[float, float, float, float] | None) -> tuple[Trapezoid | None, float]:
    if profile is None:
        return None, 0.0
    length, speed, acceleration, behind = profile
    if length < 0 or speed <= 0 or acceleration <= 0:
        raise Misfit("no profile")
    return Trapezoid(length, speed, acceleration), behind
