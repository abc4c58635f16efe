"""What a worker does: some cases, one after the other, each within its limits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Final

from hmrsim.fault_search.running.single import VERDICTS, Wanted, run_case

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
    """

    check: Check
    cases: Sequence[Case]
    story: bool = False


@lru_cache(maxsize=8)
def _warm(check: Check) -> Check:
    """Return a check that this process has worked at, if it has: with its worlds and routes."""
    return check


def execute(task: Task) -> list[Outcome]:
    """Return the outcomes of some cases, in order."""
    check = _warm(task.check)
    return [run_case(check, case, _STORY if task.story else VERDICTS) for case in task.cases]
