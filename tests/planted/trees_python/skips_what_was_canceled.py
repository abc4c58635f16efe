"""A leaf takes every status but ABORTED for a success, including that of a goal canceled to charge."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from guarded import LEAST
from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy, Status
from py_trees.composites import Parallel, Selector, Sequence
from py_trees.decorators import Inverter
from steps import patient

from bt_controller.behaviours.battery import WaitUntilCharged
from bt_controller.behaviours.robot_actions import Dock, GoTo
from bt_controller.core.port_values import node
from bt_controller.nodes.conditions.robot import IsBatteryLow
from hmrsim.protocol.goal import GoalStatus

if TYPE_CHECKING:
    from hmrsim_zenoh.client.goal_handle import GoalHandle

WARDS = ("ward_a", "ward_b", "ward_c")


class _Drive(GoTo):
    """Drives to a ward, until `_Watch` cancels its goal when the battery is low."""

    def __init__(self, place: str, drives: dict[str, Any], *, bug: bool) -> None:
        super().__init__(place)
        self._drives, self._bug = drives, bug

    def initialise(self) -> None:
        super().initialise()
        self._drives["now"] = self

    def ended(self, handle: GoalHandle[Any, Any]) -> Status:
        if self._bug and handle.error is None and handle.status is not GoalStatus.ABORTED:  # the bug: CANCELED, too
            return Status.SUCCESS
        return super().ended(handle)


class _Watch(Behaviour):
    """Cancels the running goal when the battery becomes low; succeeds when the rounds are done."""

    def __init__(self, drives: dict[str, Any]) -> None:
        super().__init__("Watch the battery")
        self._drives = drives
        self._was_low = False

    def setup(self, **kwargs: Any) -> None:
        self._topics, self._robot = kwargs["topics"], kwargs["robot"]
        self._topics.watch(self._robot, "battery_state", kwargs["wake"])

    def update(self) -> Status:
        low = self._topics.latest(self._robot, "battery_state").percentage < LEAST
        if low and not self._was_low and "now" in self._drives:
            self._drives["now"].cancel()
        self._was_low = low
        return Status.RUNNING


def mission(*, bug: bool = False) -> Behaviour:
    drives: dict[str, Any] = {}
    rounds: list[Behaviour] = []
    for ward in WARDS:
        enough = Inverter(f"Enough for {ward}", node(IsBatteryLow, min_battery=LEAST))
        charge = Sequence(f"Charge for {ward}", memory=True, children=[Dock("charger"), WaitUntilCharged(0.9)])
        battery = Selector(f"Battery for {ward}", memory=True, children=[enough, charge])
        visit = Sequence(f"Visit {ward}", memory=True, children=[battery, _Drive(ward, drives, bug=bug)])
        rounds.append(patient(visit))
    main = Sequence("Rounds", memory=True, children=[*rounds, patient(GoTo("home"))])
    return Parallel("Mission", ParallelPolicy.SuccessOnOne(), [main, _Watch(drives)])
