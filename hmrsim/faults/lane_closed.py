"""The lane is closed in both directions: no robot enters it, robots on it drive on."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Annotated

from pydantic import Field

from hmrsim.faults import Case, FaultType, Name, Spell


class LaneClosed(Spell):
    """The closure of a lane.

    Attributes:
        lane: The waypoints at the ends of the lane.
    """

    lane: Annotated[tuple[Name, ...], Field(min_length=2, max_length=2)]


def _begin(case: Case[LaneClosed]) -> Callable[[], None]:
    admission, (a, b) = case.roster.admission, case.settings.lane
    lanes = [lane for lane in ((a, b), (b, a)) if lane in admission.graph.lanes.numbers]
    cause = f"fault {case.name}"
    admission.closures.close(lanes, cause, case.name)
    return partial(admission.closures.open, cause)


FAULT = FaultType(
    name="lane_closed", settings=LaneClosed, begin=_begin, example={"lane": ["home", "door"]}, title="Closed"
)
