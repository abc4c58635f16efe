"""Nav2's conditions on the robot's battery, from the topic ``battery_state``."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar

from py_trees.common import Status

from bt_controller.core.node import Condition, PortError
from bt_controller.core.ports import BOOL, DOUBLE, STRING, Kind, input_port
from bt_controller.nodes import Family
from hmrsim.interfaces.sensor_msgs import BatteryState
from hmrsim_zenoh.client.conditions import Condition as TopicCondition

if TYPE_CHECKING:
    from bt_controller.core.ports import Places
    from bt_controller.core.topics import Topics
    from hmrsim_zenoh.client.conditions import Operator

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


FAMILY = Family.of("battery", IsBatteryCharging, IsBatteryLow)
