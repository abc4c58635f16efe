"""The motion of a vehicle as a function of time: its pose at rest, or its progress on a drive."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from hmrsim.engine.environment import At
from hmrsim.geometry import distance
from hmrsim.navigation.motion import Piece, Progress

if TYPE_CHECKING:
    from simpy import Event

    from hmrsim.engine.environment import Environment
    from hmrsim.events.robots import MotionBegan
    from hmrsim.geometry import Point, Pose
    from hmrsim.navigation.motion import Drive
    from hmrsim.navigation.route import Leg


class Motion:
    """A vehicle at rest or on a drive, where it drives a piece or waits to begin one.

    A drive has one event per decision, such as whether the next lane may be driven, and none in between.

    Args:
        at: The initial pose.
        ended: Called at the end of the pieces that were begun.

    Attributes:
        rest: The pose before the drive.
        drive: The drive that it follows; None at rest.
        drives: Whether it drives a piece now, and does not wait to begin one.
        final: The number of the last piece of the drive.
        number: The number of the piece that it drives or waits to begin; up to date after `catch_up`.
        began: The start of that piece in simulated seconds; up to date after `catch_up`.
        last: The number of the last piece before the next decision.
    """

    __slots__ = ("_end", "_ended", "_env", "_seconds", "began", "drive", "drives", "final", "last", "number", "rest")

    def __init__(self, env: Environment, at: Pose, ended: Callable[[Event], None]) -> None:
        self._env = env
        self._ended = [ended]
        self._end: At | None = None
        self._seconds: Sequence[float] = ()
        self.number = self.last = self.final = 0
        self.began = 0.0
        self.stand(at)

    def stand(self, at: Pose) -> None:
        """Put it at rest at a pose."""
        if self._end is not None:
            self._abandon_end()
        self.rest = at
        self.drive: Drive | None = None
        self.drives = False

    def detach(self) -> None:
        """Drop the callback to the vehicle, so that no reference cycle keeps a removed vehicle in memory."""
        self._abandon_end()
        self._ended.clear()

    def follow(self, drive: Drive) -> None:
        """Set the drive, and wait to begin it; it must not drive now."""
        self.drive, self._seconds, self.final = drive, drive.seconds, len(drive.seconds) - 1
        self.number = self.last = 0
        self.began = self._env.now
        self.drives = False

    def wait_at(self, number: int) -> None:
        """Wait to begin a piece of the drive."""
        if self._end is not None:
            self._abandon_end()
        self.number = self.last = number
        self.drives = False

    def begin(self, number: int, last: int) -> None:
        """Begin to drive the pieces from *number* to *last*.

        It reuses its one event, without the process that drives: with many robots, that is half of the work of a
        simulation.
        """
        self.number, self.last, self.began = number, last, self._env.now
        self.drives = True
        if self._end is None:
            self._expect_end()
        else:
            self._end.callbacks = self._ended
            ends = self.began + self._seconds[number] if number == last else self._ends()
            self._env.schedule_at(self._end, ends)

    def shorten(self, last: int) -> None:
        """End at an earlier piece, *last*."""
        self._abandon_end()
        self.last = last
        self._expect_end()

    def _expect_end(self) -> None:
        self._end = At(self._env, self._ends(), self._ended)

    def _ends(self) -> float:
        """Return the end of the last piece, in simulated seconds."""
        at = self.began
        for seconds in self._seconds[self.number : self.last + 1]:
            at += seconds
        return at

    def _abandon_end(self) -> None:
        """Abandon the event at the end of the pieces, unless it happens now."""
        end, self._end = self._end, None
        if end is not None and end.callbacks is not None:
            self._env.abandon(end)

    def catch_up(self) -> None:
        """Update `number` and `began`; at the end of a piece, the vehicle is on the next one."""
        if self.number == self.last or not self.drives:
            return
        now, seconds, number, last = self._env.now, self._seconds, self.number, self.last
        began, ends = self.began, self.began + seconds[number]
        while ends <= now and number < last:
            number += 1
            began, ends = ends, ends + seconds[number]
        self.number, self.began = number, began

    @property
    def elapsed(self) -> float:
        """The seconds since the start of its piece; 0 while it waits."""
        if not self.drives:
            return 0.0
        if self.number != self.last:
            self.catch_up()
        return self._env.now - self.began

    def pose(self) -> Pose:
        """Return the current pose."""
        if self.drive is None:
            return self.rest
        elapsed = self.elapsed
        return self.drive.pose(self.number, elapsed)

    def progress(self) -> Progress:
        """Return the current pose, and the rest of the drive; nothing remains at rest."""
        if self.drive is None:
            return Progress(self.rest)
        elapsed = self.elapsed
        return self.drive.progress(self.number, elapsed)

    @property
    def piece(self) -> Piece | None:
        """The current lane or turn; None at rest and while it waits."""
        if self.drive is None or not self.drives:
            return None
        self.catch_up()
        return self.drive.piece(self.number)

    @property
    def legs(self) -> Sequence[Leg | None]:
        """The legs of the pieces that are not complete, the current one first; None for a turn."""
        if self.drive is None:
            return ()
        self.catch_up()
        return self.drive.legs[self.number :]

    def keeps_speed(self, number: int) -> bool:
        """Return whether the piece after *number* has the same mean speed."""
        drive = self.drive
        return drive is not None and drive.piece(number).velocity == drive.piece(number + 1).velocity

    @property
    def piece_ends(self) -> float:
        """The simulated time in seconds at which the next piece begins without an event; infinite if there is none."""
        self.catch_up()
        if self.number == self.last or not self.drives:
            return math.inf
        return self.began + self._seconds[self.number]

    def is_within(self, room: float, point: Point) -> bool:
        """Return whether the vehicle is less than *room* away from a point; fast if it is far away."""
        here = self.pose().point
        return abs(here[0] - point[0]) < room and abs(here[1] - point[1]) < room and distance(here, point) < room

    def event(self, robot: str) -> MotionBegan:
        """Return the event for the start of its piece, with all pieces up to the next decision."""
        if self.drive is None:
            raise AssertionError
        first, *further = (self.drive.piece(number) for number in range(self.number, self.last + 1))
        return first.event(robot, further)

    def to_json(self) -> dict[str, Any] | None:
        """Return the current piece and those after it as JSON values; None at rest and while it waits."""
        if self.piece is None:
            return None
        fields = self.event("").to_json()
        del fields["robot"]
        return {**fields, "began": self.began}
