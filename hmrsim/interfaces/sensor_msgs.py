"""The states of batteries and joints, images, and laser scans."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from hmrsim.interfaces.geometry_msgs import Transform, Twist, Wrench
from hmrsim.interfaces.message import Bool, Float32, Float64, Message, String, UInt8
from hmrsim.interfaces.std_msgs import Header


class BatteryState(Message):
    """A battery: volts, degrees Celsius, amperes (negative when it discharges) and ampere hours.

    *percentage* is from 0 to 1. Values that are NaN in ROS as they are not measured are 0 here.
    """

    POWER_SUPPLY_STATUS_UNKNOWN: ClassVar[int] = 0
    POWER_SUPPLY_STATUS_CHARGING: ClassVar[int] = 1
    POWER_SUPPLY_STATUS_DISCHARGING: ClassVar[int] = 2
    POWER_SUPPLY_STATUS_NOT_CHARGING: ClassVar[int] = 3
    POWER_SUPPLY_STATUS_FULL: ClassVar[int] = 4

    POWER_SUPPLY_HEALTH_UNKNOWN: ClassVar[int] = 0
    POWER_SUPPLY_HEALTH_GOOD: ClassVar[int] = 1
    POWER_SUPPLY_HEALTH_OVERHEAT: ClassVar[int] = 2
    POWER_SUPPLY_HEALTH_DEAD: ClassVar[int] = 3
    POWER_SUPPLY_HEALTH_OVERVOLTAGE: ClassVar[int] = 4
    POWER_SUPPLY_HEALTH_UNSPEC_FAILURE: ClassVar[int] = 5
    POWER_SUPPLY_HEALTH_COLD: ClassVar[int] = 6
    POWER_SUPPLY_HEALTH_WATCHDOG_TIMER_EXPIRE: ClassVar[int] = 7
    POWER_SUPPLY_HEALTH_SAFETY_TIMER_EXPIRE: ClassVar[int] = 8

    POWER_SUPPLY_TECHNOLOGY_UNKNOWN: ClassVar[int] = 0
    POWER_SUPPLY_TECHNOLOGY_NIMH: ClassVar[int] = 1
    POWER_SUPPLY_TECHNOLOGY_LION: ClassVar[int] = 2
    POWER_SUPPLY_TECHNOLOGY_LIPO: ClassVar[int] = 3
    POWER_SUPPLY_TECHNOLOGY_LIFE: ClassVar[int] = 4
    POWER_SUPPLY_TECHNOLOGY_NICD: ClassVar[int] = 5
    POWER_SUPPLY_TECHNOLOGY_LIMN: ClassVar[int] = 6
    POWER_SUPPLY_TECHNOLOGY_TERNARY: ClassVar[int] = 7
    POWER_SUPPLY_TECHNOLOGY_VRLA: ClassVar[int] = 8

    header: Header = Field(default_factory=Header)
    voltage: Float32 = 0.0
    temperature: Float32 = 0.0
    current: Float32 = 0.0
    charge: Float32 = 0.0
    capacity: Float32 = 0.0
    design_capacity: Float32 = 0.0
    percentage: Float32 = 0.0
    power_supply_status: UInt8 = 0
    power_supply_health: UInt8 = 0
    power_supply_technology: UInt8 = 0
    present: Bool = False
    cell_voltage: list[Float32] = Field(default_factory=list)
    cell_temperature: list[Float32] = Field(default_factory=list)
    location: String = ""
    serial_number: String = ""


class JointState(Message):
    """Joints by name: radians or meters, their rates, newton meters or newtons."""

    header: Header = Field(default_factory=Header)
    name: list[String] = Field(default_factory=list)
    position: list[Float64] = Field(default_factory=list)
    velocity: list[Float64] = Field(default_factory=list)
    effort: list[Float64] = Field(default_factory=list)


class MultiDOFJointState(Message):
    """Joints with several degrees of freedom, by name."""

    header: Header = Field(default_factory=Header)
    joint_names: list[String] = Field(default_factory=list)
    transforms: list[Transform] = Field(default_factory=list)
    twist: list[Twist] = Field(default_factory=list)
    wrench: list[Wrench] = Field(default_factory=list)


class CompressedImage(Message):
    """A compressed image; *format* is ``jpeg`` or ``png``."""

    header: Header = Field(default_factory=Header)
    format: String = ""
    data: list[UInt8] = Field(default_factory=list)


class LaserScan(Message):
    """Distances in a plane, by angle: radians from the frame's x axis, counterclockwise, and lengths."""

    header: Header = Field(default_factory=Header)
    angle_min: Float32 = 0.0
    angle_max: Float32 = 0.0
    angle_increment: Float32 = 0.0
    time_increment: Float32 = 0.0
    scan_time: Float32 = 0.0
    range_min: Float32 = 0.0
    range_max: Float32 = 0.0
    ranges: list[Float32] = Field(default_factory=list)
    intensities: list[Float32] = Field(default_factory=list)
