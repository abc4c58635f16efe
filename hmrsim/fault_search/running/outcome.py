"""What came of one run of a schedule."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, NamedTuple

if TYPE_CHECKING:
    from hmrsim.fault_search.schedules.moment import Moment
    from hmrsim.fault_search.space.energy import Draw
    from hmrsim.properties import Verdict, Violation
    from hmrsim.properties.results import Reference


NOT_RUN: Final = "not_run"
"""The ending of a case for which there was no time."""


class Failure(NamedTuple):
    """Why a run has failed: two runs with equal failures have failed for the same reason.

    Attributes:
        property: The property's name.
        reason: Why, as a stable text without times and names.
    """

    property: str
    reason: str

    def __str__(self) -> str:
        """Return both as text."""
        return f"{self.property}: {self.reason}"


@dataclass(frozen=True)
class Outcome:
    """What came of a run.

    Attributes:
        ending: How it has ended: ``succeeded``, ``failed``, ``timeout``, ``crashed``, ``hung``, ``deadlock``, ``died``,
            ``error`` and others of an experiment's endings.
        cause: What the ending alone does not say.
        at: When it ended, in simulated seconds.
        violations: The violations of properties, in order of time.
        verdicts: What became of each property.
        features: What it has exercised, as texts, for the guidance of the search.
        moments: What happened that a fault may be anchored to.
        began: When each thing of its schedule began, in simulated seconds, in the order of the schedule; None for one
            that never did. Changes are there from the start.
        aborts: Why goals were aborted or rejected, each reason once.
        wall: Wall seconds that it took.
        trace: The trace, if it was asked for.
        story: Its events in words, if they were asked for: time in seconds, text.
        output: The last lines that a command has printed.
        coverage: What of the tree was ticked, in few bytes; empty if that is nothing new to its worker.
        items: Of a run without a schedule, if it is to be compared with: where the items are at its end.
        draws: Of a run without a schedule: what each robot with a battery has taken from it.
    """

    ending: str
    cause: str = ""
    at: float = 0.0
    violations: tuple[Violation, ...] = ()
    verdicts: tuple[Verdict, ...] = ()
    features: tuple[str, ...] = ()
    moments: tuple[Moment, ...] = ()
    began: tuple[float | None, ...] = ()
    aborts: tuple[str, ...] = ()
    wall: float = 0.0
    trace: str = ""
    story: tuple[tuple[float, str], ...] = ()
    output: str = ""
    coverage: bytes = b""
    draws: tuple[tuple[str, Draw], ...] = ()
    items: Reference | None = None

    @property
    def failure(self) -> Failure | None:
        """The first failure; None if no property was violated."""
        return next(iter(self.failures), None)

    @property
    def failures(self) -> tuple[Failure, ...]:
        """All different failures, in order of time."""
        return tuple(dict.fromkeys(Failure(each.property, each.reason) for each in self.violations))

    @property
    def robustness(self) -> float:
        """The least robustness of all properties; infinite without one."""
        return min((verdict.robustness for verdict in self.verdicts), default=float("inf"))
