"""The time of a recording: simulated time that continues after a reset."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from hmrsim.engine.sim_time import JITTER
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS, Time, values_of

if TYPE_CHECKING:
    from hmrsim.interfaces.message import Message


class Timeline:
    """Maps simulated time to the recording's time, which never goes back, even after a reset.

    Attributes:
        offset: Nanoseconds by which the recording's time is ahead of simulated time.
        begin: The first time in the recording; 0 before that.
        now: The latest time in the recording.
    """

    def __init__(self) -> None:
        self.offset = 0
        self.begin = 0
        self.now = 0

    @property
    def simulated(self) -> int:
        """The latest simulated time."""
        return self.now - self.offset

    def at(self, nanoseconds: int) -> int:
        """Return the recording's time of an instant that is current now."""
        # As everywhere, the first instant is 1: ROS reads zero as "unset".
        nanoseconds = max(1, nanoseconds)
        if nanoseconds + self.offset < self.now - JITTER:
            self.offset = self.now - (nanoseconds if nanoseconds > 1 else 0)
        self.now = max(self.now, nanoseconds + self.offset)
        self.begin = self.begin or self.now
        return self.now

    def seconds(self, simulated: float) -> float:
        """Return the recording's time of an instant, both in seconds."""
        return simulated + self.offset / NANOSECONDS

    def stamp(self, stamp: Mapping[str, int]) -> dict[str, int]:
        """Return a stamp in the recording's time, as plain values."""
        return values_of(nanoseconds_of(stamp) + self.offset)

    def message(self, message: Message) -> Message:
        """Return a message with its header's stamp, or its clock, in the recording's time."""
        if not self.offset:
            return message
        if (clock := getattr(message, "clock", None)) is not None:
            return message.model_copy(update={"clock": self._later(clock)})
        header = getattr(message, "header", None)
        if header is None:
            return message
        return message.model_copy(update={"header": header.model_copy(update={"stamp": self._later(header.stamp)})})

    def scene(self, scene: dict[str, Any]) -> dict[str, Any]:
        """Return a scene with all times in the recording's time."""
        if not self.offset:
            return scene
        return {**scene, "stamp": self.stamp(scene["stamp"]), "robots": [self._robot(each) for each in scene["robots"]]}

    def _robot(self, robot: dict[str, Any]) -> dict[str, Any]:
        motion = robot["motion"]
        if motion:
            motion = {**motion, "began": self.seconds(motion["began"])}
        return {**robot, "motion": motion, "goals": [self._goal(goal) for goal in robot["goals"]]}

    def _goal(self, goal: dict[str, Any]) -> dict[str, Any]:
        ended = goal.get("ended")
        return {**goal, "stamp": self.stamp(goal["stamp"]), "ended": None if ended is None else self.stamp(ended)}

    def _later(self, time: Time) -> Time:
        return Time.from_nanoseconds(time.to_nanoseconds() + self.offset)


def nanoseconds_of(stamp: Mapping[str, int]) -> int:
    """Return a stamp's nanoseconds."""
    return stamp["sec"] * NANOSECONDS + stamp["nanosec"]
