"""A mission that is suspended while a low battery is charged, and then resumed."""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence
from enum import Enum
from typing import TYPE_CHECKING, Any, ClassVar, Final

from py_trees.common import Status

from bt_controller.behaviours.battery import is_charging, is_full
from bt_controller.behaviours.robot_actions import NavToPoseActionClient
from bt_controller.core.node import EACH_PERIOD, Control, PortError, Ticks
from bt_controller.core.port_values import connect
from bt_controller.core.ports import SHARE, input_port
from bt_controller.core.robots import NotServed
from bt_controller.core.sim_time import now, reached, time_behind
from bt_controller.core.subtrees import finds_its_way, has_come_to_rest, repeat, suspend, verdicts
from hmrsim.interfaces.geometry_msgs import PoseStamped
from hmrsim.interfaces.nav2_msgs import NavigateToPose
from hmrsim.interfaces.sensor_msgs import BatteryState
from hmrsim_zenoh.client.connection import Condition

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour

    from bt_controller.core.robots import Topics
    from hmrsim.interfaces.nav_msgs import Odometry
    from hmrsim_zenoh.client.connection import Operator


_PATIENCE: Final = 3.0
"""Simulated seconds within which a battery has to report that it is charging."""


_MAX_FAILURES: Final = 3
"""The largest number of charges without a completed goal of the mission in between."""


class _Phase(Enum):
    """The phases of a guard."""

    MISSION = "mission"
    STOPPING = "stopping"
    CHARGE = "charge"
    FILLING = "filling"
    RETURN = "return"


class _WayBack(NavToPoseActionClient):
    """The guard's own drive back to the mission.

    Attributes:
        implied: Marks a node that no file names.
    """

    implied: Final = True


class BatteryGuardNode(Control):
    """The base of the guards of Python and XML trees: suspends its first child to charge by its second."""

    INPUTS: ClassVar = {
        "below": input_port(SHARE, "Charge below this share of the capacity, from 0 to 1", default=0.2),
        "until": input_port(SHARE, "Go on from this share", default=0.9),
    }
    least = most = 2
    """The number of children in a tree; the drive back is the guard's own child."""

    def __init__(
        self,
        name: str,
        children: Sequence[Behaviour] = (),
        behaviour_class_name: str | None = None,
        *,
        robot: str | None = None,
    ) -> None:
        self._whose_battery = robot
        back = _WayBack("Go back", lambda: self._where, robot=robot)
        super().__init__(name, children=[*children, back], behaviour_class_name=behaviour_class_name)

    def setup(self, **kwargs: Any) -> None:
        """Watch the robot's battery, and check the ports.

        Raises:
            PortError: A port's value in the file is invalid.
            NotServed: The robot has no battery.
        """
        super().setup(**kwargs)
        self._topics: Topics = kwargs["topics"]
        self._robot: str = self._whose_battery or kwargs["robot"]
        below, until = self.read("below"), self.read("until")
        if not 0 <= below < until <= 1:
            raise PortError(f"{self._whose('below')}: {below} and 'until' {until} are not as 0 <= below < until <= 1")
        self._topics.watch(self._robot, "battery_state", kwargs.get("wake"))
        # Charges before this run do not count.
        for child in self.children[1:]:
            repeat(child)

    def initialise(self) -> None:
        """Start with the mission."""
        self._phase = _Phase.MISSION
        self._shown: _Phase | None = None
        self._ended = -1
        self._in_vain = 0
        self._where: NavigateToPose.Goal | None = None
        self._filled = False
        self._charging = self._lost = False
        self._deadline = 0.0
        self._stopped_at = 0.0
        self._stood = 0.0

    def advance(self) -> Ticks:
        """Tick the current child, and choose the next one."""
        mission, _, back = self.children
        battery: BatteryState = self._topics.latest(self._robot, "battery_state")
        if self._phase in (_Phase.MISSION, _Phase.RETURN) and battery.percentage < self.read("below"):
            if self._phase is _Phase.MISSION and not self._gets_on():
                self.feedback_message = f"charged {_MAX_FAILURES} times, and no goal has ended in between"
                return Status.FAILURE
            self._stop()
        if self._phase is _Phase.STOPPING and has_come_to_rest(mission) and has_come_to_rest(back):
            self._begin_charge()
        if self._phase in (_Phase.CHARGE, _Phase.FILLING) and not (yield from self._charge(battery)):
            return Status.FAILURE
        if self._phase is _Phase.RETURN and not (yield from self._return()):
            return Status.FAILURE
        if self._shown is not self._phase:
            self._shown = self._phase
            self.feedback_message = f"{self._phase.value}, battery {battery.percentage:.0%}"
        if self._phase is not _Phase.MISSION:
            return Status.RUNNING
        with time_behind(self._stood):
            yield from mission.tick()
        return mission.status

    def next_tick_time(self) -> float:
        """Return that the battery has to be polled in lockstep, unless time stops for it."""
        if self.status is not Status.RUNNING or self._lost:
            return EACH_PERIOD
        filling = self._phase is _Phase.FILLING
        if self._stops_time:
            return self._deadline if filling and not (self._filled or self._charging) else math.inf
        return EACH_PERIOD if filling or self._topics.asks else math.inf

    def awaited(self) -> Sequence[Condition]:
        """Return what levels of the battery the guard waits for."""
        if self.status is not Status.RUNNING or not self._stops_time:
            return ()
        if self._phase in (_Phase.MISSION, _Phase.RETURN):
            return [self._battery_is("/percentage", "<", self.read("below"))]
        if self._filled or self._phase is _Phase.STOPPING:
            return ()
        filled = [
            self._battery_is("/percentage", ">=", self.read("until")),
            self._battery_is("/power_supply_status", "==", BatteryState.POWER_SUPPLY_STATUS_FULL),
        ]
        if self._phase is _Phase.CHARGE or not self._charging:
            return filled
        # It may stop before.
        return [*filled, self._battery_is("/power_supply_status", "!=", BatteryState.POWER_SUPPLY_STATUS_CHARGING)]

    @property
    def _stops_time(self) -> bool:
        return self._topics.stop_time(self._robot, "battery_state")

    def _battery_is(self, field: str, operator: Operator, value: float) -> Condition:
        return Condition(f"{self._robot}/battery_state", ((field, operator, value),))

    def next_ticked(self) -> list[Behaviour]:
        """Return the current child."""
        turns = {_Phase.MISSION: 0, _Phase.CHARGE: 1, _Phase.RETURN: 2}
        turn = self.children[turns[self._phase]] if self._phase in turns else None
        return [turn] if turn is not None and turn.status is Status.RUNNING else []

    @property
    def behind(self) -> float:
        """By how many seconds the time of the next child is behind."""
        return self._stood if self._phase is _Phase.MISSION else 0.0

    def _gets_on(self) -> bool:
        """Return whether to charge once more: goals have ended since the last charge, or there were few charges."""
        ended = verdicts(self.children[0])
        self._in_vain = self._in_vain + 1 if ended == self._ended else 0
        self._ended = ended
        return self._in_vain < _MAX_FAILURES

    def _stop(self) -> None:
        mission, _, back = self.children
        if self._phase is _Phase.MISSION:
            self._where = None
            self._stopped_at = now()
        self._phase = _Phase.STOPPING
        self.halt(back)
        suspend(mission)

    def _begin_charge(self) -> None:
        """Remember where the robot is, and begin to charge it; wait if the robot is out of reach."""
        if self._where is None:
            try:
                odometry: Odometry = self._topics.ask(self._robot, "odom")
            except NotServed as error:
                self.feedback_message, self._lost = str(error), True
                return
            self._where = NavigateToPose.Goal(pose=PoseStamped(header=odometry.header, pose=odometry.pose.pose))
        self._lost = False
        self._phase = _Phase.CHARGE
        self._filled = False
        self.reset(self.children[1])

    def _charge(self, battery: BatteryState) -> Generator[Behaviour, None, bool]:
        """Charge the battery by the second child; return whether that has not failed."""
        charge = self.children[1]
        self._filled = self._filled or is_full(battery) or battery.percentage >= self.read("until")
        self._charging = is_charging(battery)
        if self._phase is _Phase.CHARGE:
            yield from charge.tick()
            if charge.status is Status.SUCCESS:
                self._phase, self._deadline = _Phase.FILLING, now() + _PATIENCE
            elif charge.status is not Status.RUNNING:
                self.feedback_message = f"the battery is at {battery.percentage:.0%}, and charging it failed"
                return False
        if self._phase is _Phase.FILLING:
            if not (self._filled or self._charging) and reached(self._deadline):
                self.feedback_message = f"charged to {battery.percentage:.0%} only"
                return False
            if self._filled and has_come_to_rest(charge):
                self._phase = _Phase.RETURN
        return True

    def _return(self) -> Generator[Behaviour, None, bool]:
        """Drive the robot back to where the mission resumes; return whether that has not failed."""
        mission, _, back = self.children
        if not finds_its_way(mission):
            yield from back.tick()
            if back.status is Status.RUNNING:
                return True
            if back.status is not Status.SUCCESS:
                self.feedback_message = f"charged, but can't get back: {back.feedback_message}"
                return False
            self.reset(back)
        self._phase = _Phase.MISSION
        self._stood += now() - self._stopped_at
        return True


class BatteryGuard(BatteryGuardNode):
    """Runs a mission, and suspends it to charge when the battery is low.

    ::

        BatteryGuard("Guard", mission=errand, charge=Dock("charger_1"), below=0.2, until=0.9)

    Args:
        name: The behavior's name.
        mission: The mission. It and its timers stand still while the battery is charged: its active goals are
            canceled and sent again afterwards, and its finished steps stay finished. First the robot drives back to
            where it was interrupted, unless the mission resumes with a drive.
        charge: The subtree that charges the battery. If it ends while the battery is charging, as docking does, the
            guard waits for the charge; if it waits and undocks itself, the mission resumes at once.
        below: The share of the capacity below which to charge, from 0 to 1.
        until: The share from which the mission resumes.
        robot: The robot with the battery; None for the one that the tree is run for.
    """

    def __init__(
        self,
        name: str,
        mission: Behaviour,
        charge: Behaviour,
        *,
        below: float = 0.2,
        until: float = 0.9,
        robot: str | None = None,
    ) -> None:
        super().__init__(name, children=[mission, charge], robot=robot)
        connect(self, below=below, until=until)
