"""The sensors of the robot see nothing."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from hmrsim.components import Sensor
from hmrsim.faults import Case, FaultType, Name, Spell


class SensorBlind(Spell):
    """Blindness of a robot's sensors.

    Attributes:
        robot: The robot's name.
        sensor: The sensor's component, such as ``camera``; None for all sensors.
    """

    robot: Name
    sensor: Name | None = None


def _begin(case: Case[SensorBlind]) -> Callable[[], None]:
    robot = case.robot

    def update(blinding: tuple[SensorBlind, ...]) -> None:
        causes = [each.sensor for each in (*blinding, *case.concurrent())]
        for name, one in robot.components.items():
            if isinstance(one, Sensor):
                one.set_blind(blind=None in causes or name in causes)

    update((case.settings,))
    return partial(update, ())


FAULT = FaultType(
    name="sensor_blind",
    settings=SensorBlind,
    begin=_begin,
    example={"robot": "wall_e"},
    title="Blind sensors",
    changes="sensors",
)
