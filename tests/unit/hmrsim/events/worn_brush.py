"""A fault as another package would define it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.faults import Case, FaultType, Name, Occurrence
from tests.unit.hmrsim.events.cleaning import BrushWorn

if TYPE_CHECKING:
    from collections.abc import Callable


class WornBrush(Occurrence):
    """When which robot's brush is worn out."""

    robot: Name


def _begin(case: Case[WornBrush]) -> Callable[[], None]:
    case.publish(lambda: BrushWorn(case.settings.robot))
    return lambda: None


FAULT = FaultType(name="worn_brush", settings=WornBrush, begin=_begin)
