"""The motion of a robot along a route: pieces whose pose is a formula of time, without time steps.

A lane takes length / speed. A robot with an acceleration drives each straight stretch from rest to rest with a
trapezoidal speed; one with a turning rate turns in place where the stretch bends. Both are closed formulas.

A robot that is rerouted while it drives keeps its speed if the new route leads straight on: as if the stretch had begun
where the robot would have had to set out to have that speed now.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from hmrsim.caches import LruCache, exact
from hmrsim.events.robots import MotionBegan
from hmrsim.geometry import Pose, between, distance, turn
from hmrsim.navigation.route import Leg

if TYPE_CHECKING:
    from hmrsim.geometry import Point

_SAME_HEADING = 1e-9


@dataclass(frozen=True, slots=True)
class Trapezoid:
    """Driving a distance from rest to rest, with a greatest speed and an acceleration.

    Where the distance is too short to reach the speed, the trapezoid is a triangle.

    Attributes:
        duration: Seconds from rest to rest.
    """

    distance: float
    speed: float
    acceleration: float
    duration: float = field(init=False, compare=False, repr=False)
    _ramp: tuple[float, float] = field(init=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        """Compute the duration, and the seconds and distance of speeding up and of slowing down."""
        reached = min(self.speed, math.sqrt(self.distance * self.acceleration))
        seconds, length = reached / self.acceleration, reached * reached / (2 * self.acceleration)
        object.__setattr__(self, "_ramp", (seconds, length))
        object.__setattr__(self, "duration", 2 * seconds + (self.distance - 2 * length) / self.speed)

    def time(self, distance: float) -> float:
        """Return the seconds after which *distance* has been driven."""
        seconds, length = self._ramp
        if distance <= length:
            return math.sqrt(2 * distance / self.acceleration)
        if distance <= self.distance - length:
            return seconds + (distance - length) / self.speed
        return self.duration - math.sqrt(2 * max(0.0, self.distance - distance) / self.acceleration)

    def driven(self, time: float) -> float:
        """Return the distance that has been driven after *time* seconds."""
        seconds, length = self._ramp
        duration = self.duration
        if time <= seconds:
            return self.acceleration * time * time / 2
        if time <= duration - seconds:
            return length + (time - seconds) * self.speed
        left = max(0.0, duration - time)
        return self.distance - self.acceleration * left * left / 2

    def run_up(self, distance: float) -> float:
        """Return from how far back one has to set out to be as fast as after *distance*."""
        return min(distance, self._ramp[1], self.distance - distance)


class Piece(NamedTuple):
    """A piece of a motion, such as a lane or a turn, at whose end there is one event.

    Attributes:
        length: Driven, in the world's unit; 0 for a turn, and for a ride in a lift.
        duration: Seconds.
        leg: The leg that is driven; None for a turn.
        profile: Speed over the stretch of which this is a part; None for a constant speed.
        driven_before: How much of that stretch comes before this piece.
        turned: Radians of a turn, counter-clockwise where y is up; more than half a turn leads the long way round.
    """

    start: Pose
    end: Pose
    length: float
    duration: float
    leg: Leg | None = None
    profile: Trapezoid | None = None
    driven_before: float = 0.0
    turned: float = 0.0

    @property
    def velocity(self) -> tuple[float, float]:
        """The mean speed ahead, negative if backwards, and the turning rate."""
        if not self.duration:
            return 0.0, 0.0
        backwards = self.leg is not None and abs(turn(self.leg.first.yaw, self.start.yaw)) > math.pi / 2
        length = -self.length if backwards and self.length else self.length
        return length / self.duration, self.turned / self.duration

    def event(self, robot: str, further: Iterable[Piece] = ()) -> MotionBegan:
        """Return the event that a robot begins it, with the data that a subscriber needs to draw it.

        Args:
            robot: The robot's name.
            further: The pieces that it drives after it without a further event.
        """
        leg, profile = self.leg, self.profile
        return MotionBegan(
            robot,
            self.start,
            self.end,
            self.duration,
            leg.lane if leg else None,
            turned=None if leg else self.turned,
            ride=bool(leg and leg.ride),
            profile=(profile.distance, profile.speed, profile.acceleration, self.driven_before) if profile else None,
            then=tuple(piece.describe() for piece in further),
        )

    def describe(self) -> dict[str, Any]:
        """Return the data that an observer needs to draw the piece, as JSON values."""
        fields = self.event("").to_json()
        del fields["robot"]
        return fields

    def driven(self, elapsed: float) -> float:
        """Return the length driven *elapsed* seconds after the start, from 0 to `length`."""
        if elapsed >= self.duration:
            return self.length
        if self.profile is None:
            return self.length * elapsed / self.duration
        began = self.profile.time(self.driven_before)
        return min(self.length, max(0.0, self.profile.driven(began + elapsed) - self.driven_before))

    def pose(self, elapsed: float) -> Pose:
        """Return the pose *elapsed* seconds after the start."""
        if elapsed >= self.duration:
            return self.end
        if self.leg is None or self.leg.ride:
            return Pose(*self.start.point, self.start.yaw + self.turned * elapsed / self.duration)
        return Pose(*between(self.start.point, self.end.point, self.driven(elapsed) / self.length), self.start.yaw)

    def run_up(self, elapsed: float) -> float:
        """Return from how far back one has to set out to be as fast as *elapsed* seconds after the start, ahead."""
        if self.profile is None or self.velocity[0] <= 0.0:
            return 0.0
        return max(0.0, self.profile.run_up(self.driven_before + self.driven(elapsed)))

    def first(self, seconds: float) -> Piece:
        """Return the part of the piece up to a number of seconds, which ends in the middle of the motion."""
        if seconds >= self.duration:
            return self
        turned = self.turned * seconds / self.duration
        return self._replace(end=self.pose(seconds), length=self.driven(seconds), duration=seconds, turned=turned)


class Progress(NamedTuple):
    """The progress of a robot on its route.

    Attributes:
        length: Remaining length of the way, in the world's unit.
        seconds: How long that takes, if nothing gets in the way.
    """

    pose: Pose
    length: float = 0.0
    seconds: float = 0.0


class Drive(Protocol):
    """A drive along a route, piece by piece."""

    @property
    def seconds(self) -> Sequence[float]:
        """The duration of each piece, in seconds."""

    @property
    def legs(self) -> Sequence[Leg | None]:
        """The leg that each piece drives; None for a turn."""

    @property
    def in_pieces(self) -> bool:
        """Return whether the duration of each piece is independent, so that a robot may stop between any two."""

    @property
    def end(self) -> Pose:
        """The pose at the end; only a motion with pieces has one."""

    def piece(self, number: int) -> Piece:
        """Return the piece of this index."""

    def pose(self, number: int, elapsed: float) -> Pose:
        """Return where one is *elapsed* seconds after the start of the piece of this index."""

    def progress(self, number: int, elapsed: float) -> Progress:
        """Return how far one is *elapsed* seconds after the start of the piece of this index."""


class _Steady:
    """A drive at constant speeds, in which each leg is a piece that is created when it is first read."""

    __slots__ = ("_after", "legs", "seconds")
    in_pieces = True

    def __init__(self, legs: Sequence[Leg], speed: float) -> None:
        self.legs = legs
        self._after: list[tuple[float, float]] = []
        self.seconds = [
            leg.ride or leg.length / (leg.speed_limit if leg.speed_limit < speed else speed)  # noqa: FURB136 - min() is slow
            for leg in legs
        ]

    @property
    def end(self) -> Pose:
        return self.legs[-1].last

    def piece(self, number: int) -> Piece:
        leg = self.legs[number]
        return Piece(leg.first, leg.last, leg.length, self.seconds[number], leg)

    def pose(self, number: int, elapsed: float) -> Pose:
        leg, duration = self.legs[number], self.seconds[number]
        if elapsed >= duration:
            return leg.last
        if not elapsed or leg.ride:
            return leg.first
        share = elapsed / duration
        (ax, ay), (bx, by) = leg.start, leg.end
        return Pose(ax + (bx - ax) * share, ay + (by - ay) * share, leg.first.yaw)

    def progress(self, number: int, elapsed: float) -> Progress:
        # Asked with every feedback, if with any.
        self._after = self._after or _sums_behind([leg.length for leg in self.legs], self.seconds)
        length, seconds = self._after[number]
        leg, duration = self.legs[number], self.seconds[number]
        if elapsed >= duration:
            return Progress(leg.last, length, seconds)
        share = 0.0 if leg.ride else elapsed / duration
        left = leg.length * (1.0 - share)
        return Progress(self.pose(number, elapsed), left + length, duration - elapsed + seconds)


class _Profiled:
    """A drive with accelerations or turns, whose pieces depend on each other."""

    __slots__ = ("_after", "_pieces", "legs", "seconds")
    in_pieces = False

    def __init__(self, pieces: Sequence[Piece]) -> None:
        self._pieces = pieces
        self.legs = [piece.leg for piece in pieces]
        self.seconds = [piece.duration for piece in pieces]
        self._after: list[tuple[float, float]] = []

    @property
    def end(self) -> Pose:
        return self._pieces[-1].end

    def piece(self, number: int) -> Piece:
        return self._pieces[number]

    def pose(self, number: int, elapsed: float) -> Pose:
        return self._pieces[number].pose(elapsed)

    def progress(self, number: int, elapsed: float) -> Progress:
        piece = self._pieces[number]
        self._after = self._after or _sums_behind([each.length for each in self._pieces], self.seconds)
        length, seconds = self._after[number]
        left = piece.length - piece.driven(elapsed)
        return Progress(piece.pose(elapsed), left + length, max(0.0, piece.duration - elapsed) + seconds)


def _sums_behind(lengths: Sequence[float], seconds: Sequence[float]) -> list[tuple[float, float]]:
    """Return for each index the sums of the following values."""
    length, time = 0.0, 0.0
    sums = []
    for i in range(len(lengths) - 1, -1, -1):
        sums.append((length, time))
        length, time = length + lengths[i], time + seconds[i]
    return sums[::-1]


def drive(
    start: Pose,
    legs: Sequence[Leg],
    final_yaw: float | None,
    *,
    speed: float,
    acceleration: float | None = None,
    turning_rate: float | None = None,
    run_up: float = 0.0,
) -> Drive:
    """Return the drive along *legs* from *start*, which ends with a turn to *final_yaw*, if any.

    Without a turning rate turns take no time and need no piece. With a *run_up* it begins as fast as one is after so
    much, if it begins straight ahead.
    """
    if not acceleration and not turning_rate:
        return _Steady(legs, speed)
    made: list[Piece] = []
    pose = start
    for stretch in _stretches(legs):
        if stretch[0].ride:
            pose = _ride(made, pose, stretch[0])
            continue
        yaw = stretch[0].first.yaw
        pose = _turn(made, pose, yaw, turning_rate)
        total = math.fsum(leg.length for leg in stretch)
        top = min(speed, stretch[0].speed_limit)
        before = began = 0.0
        profile = None
        if acceleration:
            if run_up and not made and abs(turn(start.yaw, yaw)) <= _SAME_HEADING:
                before = min(run_up, total, top * top / (2 * acceleration))
            profile = Trapezoid(before + total, top, acceleration)
            began = profile.time(before)
        for leg in stretch:
            seconds = leg.length / top
            if profile:
                ended = profile.time(before + leg.length)
                began, seconds = ended, ended - began
            end = Pose(*leg.end, yaw)
            made.append(Piece(Pose(*leg.start, yaw), end, leg.length, seconds, leg, profile, before))
            before += leg.length
            pose = end
    if final_yaw is not None:
        _turn(made, pose, final_yaw, turning_rate)
    return _Profiled(made)


class Drives:
    """A cache of the latest drives on a map, for robots that accelerate or take time to turn.

    Args:
        most: How many are kept.
    """

    def __init__(self, most: int) -> None:
        self._kept: LruCache[tuple[Any, ...], Drive] = LruCache(most)

    def drive(
        self,
        start: Pose,
        legs: Sequence[Leg],
        final_yaw: float | None,
        *,
        speed: float,
        acceleration: float | None = None,
        turning_rate: float | None = None,
        run_up: float = 0.0,
    ) -> Drive:
        """Return the result of the function `drive`, from the cache if possible."""
        if not acceleration and not turning_rate:
            return _Steady(legs, speed)
        yaw = math.nan if final_yaw is None else final_yaw
        numbers = exact(*start, yaw, speed, acceleration or 0.0, turning_rate or 0.0, run_up)
        # A drive that is kept holds its legs, so that no others have their ids.
        return self._kept.get(
            (numbers, *map(id, legs)),
            lambda: drive(
                start,
                legs,
                final_yaw,
                speed=speed,
                acceleration=acceleration,
                turning_rate=turning_rate,
                run_up=run_up,
            ),
        )


def spin(start: Pose, angle: float, turning_rate: float | None) -> Piece:
    """Return a turn by an angle; without a turning rate, it takes no time. Full turns are kept in the final yaw."""
    seconds = abs(angle) / turning_rate if turning_rate else 0.0
    return Piece(start, Pose(*start.point, start.yaw + angle), 0.0, seconds, turned=angle)


def straight(start: Pose, end: Point, *, speed: float, acceleration: float | None = None) -> Piece:
    """Return the straight motion to a point other than the start, without turning; backwards if it lies behind."""
    leg = Leg(start.point, end, distance(start.point, end))
    profile = Trapezoid(leg.length, speed, acceleration) if acceleration else None
    seconds = profile.duration if profile else leg.length / speed
    return Piece(start, Pose(*end, start.yaw), leg.length, seconds, leg, profile)


def steered(start: Pose, speed: float, turning_rate: float, seconds: float) -> Piece:
    """Return a short motion at constant velocities; a bend is approximated by its chord, with the yaw at its end.

    Args:
        start: The pose at the start.
        speed: Ahead, or backwards if it is negative; in the world's unit a second.
        turning_rate: Radians a second.
        seconds: The duration.
    """
    angle = turning_rate * seconds
    if not speed:
        return Piece(start, Pose(*start.point, start.yaw + angle), 0.0, seconds, turned=angle)
    length, heading = speed * seconds, start.yaw + angle / 2
    end = start.x + length * math.cos(heading), start.y + length * math.sin(heading)
    leg = Leg(start.point, end, abs(length))
    return Piece(start, Pose(*end, start.yaw + angle), abs(length), seconds, leg)


def drive_of(*pieces: Piece) -> Drive:
    """Return a motion of some pieces."""
    return _Profiled(pieces)


def _turn(made: list[Piece], pose: Pose, yaw: float, turning_rate: float | None) -> Pose:
    """Add the turn from *pose* to *yaw*, if it takes time; return the pose after it."""
    after = Pose(*pose.point, yaw)
    angle = turn(pose.yaw, yaw)
    if turning_rate and abs(angle) > _SAME_HEADING:
        made.append(Piece(pose, after, 0.0, abs(angle) / turning_rate, turned=angle))
    return after


def _ride(made: list[Piece], pose: Pose, leg: Leg) -> Pose:
    """Add a ride, in which the robot does not turn; return the pose after it."""
    after = Pose(*leg.end, pose.yaw)
    made.append(Piece(pose, after, 0.0, leg.ride, leg))
    return after


def _stretches(legs: Sequence[Leg]) -> list[list[Leg]]:
    """Return the legs grouped into straight runs with one speed limit; a ride is a separate run."""
    runs: list[list[Leg]] = []
    for leg in legs:
        if runs and _continues(runs[-1][-1], leg):
            runs[-1].append(leg)
        else:
            runs.append([leg])
    return runs


def _continues(before: Leg, leg: Leg) -> bool:
    if before.ride or leg.ride:
        return False
    bend = turn(before.first.yaw, leg.first.yaw)
    return before.speed_limit == leg.speed_limit and abs(bend) <= _SAME_HEADING
