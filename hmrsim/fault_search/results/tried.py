"""What a search has tried."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hmrsim.fault_search.schedules.thing import Schedule


@dataclass
class Tried:
    """What was tried.

    Attributes:
        runs: How many runs there were.
        failed: How many of them violated a property.
        singles: How many single things there are, each at each moment.
        singles_left: How many of them were not tried.
        kinds: How often each kind of thing was in a schedule.
        begun: How often it began.
        exercised: How often each property was.
        endings: How the runs have ended.
        transient: How many runs had faults that were all transient, and nothing else.
        gave_up: In how many of these the controller ended as failed.
        gave_up_first: The schedule of the first of them.
    """

    runs: int = 0
    failed: int = 0
    singles: int = 0
    singles_left: int = 0
    kinds: Counter[str] = field(default_factory=Counter)
    begun: Counter[str] = field(default_factory=Counter)
    exercised: Counter[str] = field(default_factory=Counter)
    endings: Counter[str] = field(default_factory=Counter)
    transient: int = 0
    gave_up: int = 0
    gave_up_first: Schedule = ()
