"""What a worker does: some cases, one after the other, each within its limits, as long as there is time."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Final

from hmrsim.fault_search.running.single import VERDICTS, Wanted, run_within

if TYPE_CHECKING:
    from hmrsim.fault_search.file.check import Check
    from hmrsim.fault_search.running.outcome import Outcome
    from hmrsim.fault_search.schedules.case import Case

_STORY: Final = Wanted(trace=True, story=True)


@dataclass(frozen=True)
class Task:
    """Some cases of a check.

    Attributes:
        check: The check.
        cases: The cases.
        story: Whether their traces and events are wanted.
        seconds: Wall seconds that there are for them.
    """

    check: Check
    cases: Sequence[Case]
    story: bool = False
    seconds: float = math.inf


@lru_cache(maxsize=8)
def _warm(check: Check) -> Check:
    """Return a check that this process has worked at, if it has: with its worlds and routes."""
    return check


def execute(task: Task) -> list[Outcome]:
    """Return the outcomes of some cases, in order; fewer if the time for them is over."""
    check = _warm(task.check)
    until = time.monotonic() + task.seconds
    outcomes: list[Outcome] = []
    for case in task.cases:
        left = until - time.monotonic()
        outcome = run_within(check, case, _STORY if task.story else VERDICTS, left) if left > 0.0 else None
        if outcome is None:
            break
        outcomes.append(outcome)
    return outcomes
