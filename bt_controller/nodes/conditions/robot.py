"""Nav2's conditions on the robot's motion, localization and battery, and on simulated time.

Lengths are in the world's unit.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Final

from py_trees.common import Status

from bt_controller.core.node import Condition, Leaf, PortError
from bt_controller.core.ports import BOOL, DOUBLE, FINITE, PATH, STRING, Kind, input_port
from bt_controller.core.sim_time import now, reached
from bt_controller.nodes import Family
from bt_controller.nodes.poses import BASE_FRAME, GLOBAL_FRAME, Located, apart
from hmrsim.interfaces.sensor_msgs import BatteryState
from hmrsim_zenoh.client.connection import Condition as TopicCondition

if TYPE_CHECKING:
    from bt_controller.core.ports import Places
    from bt_controller.core.robots import Topics
    from hmrsim.interfaces.nav_msgs import Odometry, Path
    from hmrsim_zenoh.client.connection import Operator


class DistanceTraveled(Located, Condition):
    """Succeeds each time the robot is ``distance`` away from its position at the last success or the first tick.

    The distance is measured in a straight line.
    """

    INPUTS: ClassVar = {
        "distance": input_port(FINITE, "The distance", default=1.0),
        "global_frame": GLOBAL_FRAME,
        "robot_base_frame": BASE_FRAME,
    }

    def update(self) -> Status:
        """Compare the robot's position with the earlier one."""
        here = self.here
        if self.status is Status.INVALID:
            self._start = here
            return Status.FAILURE
        if apart(self._start, here) < self.read("distance"):
            return Status.FAILURE
        self._start = here
        return Status.SUCCESS


class IsStopped(Located, Condition):
    """Succeeds if the robot has been slower than ``velocity_threshold`` for ``duration_stopped`` milliseconds.

    RUNNING while it is slow, but not long enough yet; fails if it is faster. The time is counted again after that, and
    after a success or a halt. The threshold applies to each direction, and to radians per second. The speed is polled
    once per period, so the node may succeed up to a period late.
    """

    INPUTS: ClassVar = {
        "velocity_threshold": input_port(FINITE, "Largest speed, per second", default=0.01),
        "duration_stopped": input_port(FINITE, "Duration in milliseconds", default=1000.0),
    }

    _until: float | None = None

    def initialise(self) -> None:
        """Start the duration at the next tick."""
        self._until = None

    def update(self) -> Status:
        """Compare the robot's speed with the threshold."""
        velocity = self.odometry.twist.twist
        fastest = max(abs(velocity.linear.x), abs(velocity.linear.y), abs(velocity.angular.z))
        if fastest >= self.read("velocity_threshold"):
            return Status.FAILURE
        if self._until is None:
            self._until = now() + self.read("duration_stopped") / 1000.0
        return Status.SUCCESS if reached(self._until) else Status.RUNNING


class CheckStopStatus(IsStopped):
    """Same as ``IsStopped``, under another name."""


class IsStuck(Located, Condition):
    """Succeeds if the robot has decelerated by 10 units of length per second squared or more.

    Nav2 considers that a collision. The robot's speed is compared with that at the previous tick, so the result depends
    on how often the node is ticked.
    """

    MIN_ACCELERATION: ClassVar = -10.0

    _before: Odometry | None = None

    def update(self) -> Status:
        """Compare the robot's speed with that at the previous tick."""
        before, self._before = self._before, self.odometry
        if before is None:
            return Status.FAILURE
        began, ended = (odometry.header.stamp.to_nanoseconds() * 1e-9 for odometry in (before, self._before))
        if ended <= began:
            return Status.FAILURE
        gained = self._before.twist.twist.linear.x - before.twist.twist.linear.x
        return Status.SUCCESS if gained / (ended - began) < self.MIN_ACCELERATION else Status.FAILURE


_FRAMES: Final = ("map", "base_link")


class InitialPoseReceived(Leaf):
    """Succeeds unless the file sets the port to false: simulated robots are localized from the start."""

    INPUTS: ClassVar = {"initial_pose_received": input_port(BOOL, "Whether there is a pose", default=True)}

    def update(self) -> Status:
        """Return the port's value as a status."""
        return Status.SUCCESS if self.read("initial_pose_received") else Status.FAILURE


class TransformAvailable(Leaf):
    """Succeeds if both frames are known: ``map`` and ``base_link`` are, and no others."""

    INPUTS: ClassVar = {"child": input_port(STRING, "One frame"), "parent": input_port(STRING, "The other")}

    def update(self) -> Status:
        """Check the frames."""
        unknown = [frame for frame in map(self.read, self.INPUTS) if frame not in _FRAMES]
        if unknown:
            self.feedback_message = f"no frame {unknown[0]!r}; there are {' and '.join(_FRAMES)}"
            return Status.FAILURE
        return Status.SUCCESS


_SECONDS = input_port(FINITE, "Duration in seconds", default=1.0)


class TimeExpired(Condition):
    """Succeeds each time ``seconds`` have passed since its last success or its first tick."""

    INPUTS: ClassVar = {"seconds": _SECONDS}

    _until = 0.0

    def next_tick_time(self) -> float:
        """Return the end of the duration."""
        return self._until

    def update(self) -> Status:
        """Check the time."""
        begins = self.status is Status.INVALID
        over = not begins and reached(self._until)
        if begins or over:
            self._until = now() + self.read("seconds")
        return Status.SUCCESS if over else Status.FAILURE


class PathExpiringTimer(Condition):
    """Succeeds each time ``seconds`` have passed since its first tick, its last success or the last change of path."""

    INPUTS: ClassVar = {"seconds": _SECONDS, "path": input_port(PATH, "The path", required=False)}

    _until: float | None = None
    _path: Path | None = None

    def next_tick_time(self) -> float:
        """Return the end of the duration."""
        return 0.0 if self._until is None else self._until

    def update(self) -> Status:
        """Check the time."""
        path = self.read("path")
        if self._until is None or path != self._path:
            self._path = path
            self._until = now() + self.read("seconds")
            return Status.FAILURE
        if not reached(self._until):
            return Status.FAILURE
        self._until = now() + self.read("seconds")
        return Status.SUCCESS


_TOPIC = "battery_state"
_NAV2_TOPIC = "battery_status"
"""The name of the topic in Nav2's own trees."""


def _owner(topic: str) -> str:
    """Return the robot whose battery state is on a topic; empty for the tree's own robot.

    Raises:
        ValueError: The topic is not that of a battery state.
    """
    robot, _, name = topic.strip().removeprefix("/").rpartition("/")
    if name not in (_TOPIC, _NAV2_TOPIC) or "/" in robot:
        raise ValueError(
            f"no topic {topic!r}; the battery state is on {_TOPIC!r}, or {_NAV2_TOPIC!r} as in Nav2's trees, that of"
            f" another robot on 'ROBOT/{_TOPIC}'"
        )
    return robot


def _read_topic(text: str, _places: Places | None) -> str:
    _owner(text)
    return text


_BATTERY_TOPIC = input_port(
    Kind(STRING.name, str, _read_topic),
    f"Topic of the battery state: {_TOPIC}, or {_NAV2_TOPIC} as in Nav2's trees; of another robot: ROBOT/{_TOPIC}",
    default=_TOPIC,
)


class _Battery(Condition):
    """A condition on the battery, which is ticked again when its verdict changes."""

    INPUTS: ClassVar = {"battery_topic": _BATTERY_TOPIC}

    def setup(self, **kwargs: Any) -> None:
        """Subscribe to the battery state.

        Raises:
            NotServed: The robot has no battery.
            PortError: A port's value in the file is invalid.
        """
        super().setup(**kwargs)
        try:
            robot = _owner(self.read("battery_topic"))
        except ValueError as error:
            raise PortError(f"{self._whose('battery_topic')}: {error}") from None
        self._topics: Topics = kwargs["topics"]
        self._battery_owner: str = robot or kwargs["robot"]
        self._topics.watch(self._battery_owner, _TOPIC)

    def next_tick_time(self) -> float:
        """Poll the battery, unless time stops when the verdict changes."""
        return math.inf if self.awaited() else super().next_tick_time()

    def awaited(self) -> Sequence[TopicCondition]:
        """Return the condition under which the verdict changes, if time can stop for it."""
        change = self._verdict_change() if self.status in (Status.SUCCESS, Status.FAILURE) else None
        if change is None or not self._topics.stop_time(self._battery_owner, _TOPIC):
            return ()
        return (TopicCondition(f"{self._battery_owner}/{_TOPIC}", (change,)),)

    def _verdict_change(self) -> tuple[str, Operator, float] | None:
        """Return the comparison that holds as soon as the verdict changes; None if the topic can't be compared."""
        raise NotImplementedError

    @property
    def battery(self) -> BatteryState:
        """The latest state of the battery."""
        latest: BatteryState = self._topics.latest(self._battery_owner, _TOPIC)
        return latest


class IsBatteryLow(_Battery):
    """Succeeds if the battery is at ``min_battery`` or below: a share from 0 to 1, or volts with ``is_voltage``."""

    INPUTS: ClassVar = {
        "min_battery": input_port(DOUBLE, "Threshold"),
        "battery_topic": _BATTERY_TOPIC,
        "is_voltage": input_port(BOOL, "Whether the threshold is in volts", default=False),
    }

    def update(self) -> Status:
        """Check the battery."""
        level = self.battery.voltage if self.read("is_voltage") else self.battery.percentage
        self.feedback_message = f"at {level:g}"
        return Status.SUCCESS if level <= self.read("min_battery") else Status.FAILURE

    def _verdict_change(self) -> tuple[str, Operator, float] | None:
        # Time can stop for the percentage, which is a formula of time; the voltage is known only with each message.
        if self.read("is_voltage"):
            return None
        return "/percentage", ">" if self.status is Status.SUCCESS else "<=", self.read("min_battery")


class IsBatteryCharging(_Battery):
    """Succeeds if the battery is being charged."""

    def update(self) -> Status:
        """Check the battery."""
        charging = self.battery.power_supply_status == BatteryState.POWER_SUPPLY_STATUS_CHARGING
        return Status.SUCCESS if charging else Status.FAILURE

    def _verdict_change(self) -> tuple[str, Operator, float] | None:
        operator: Operator = "!=" if self.status is Status.SUCCESS else "=="
        return "/power_supply_status", operator, BatteryState.POWER_SUPPLY_STATUS_CHARGING


FAMILY = Family.of_module(__name__)
