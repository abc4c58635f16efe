"""The summary of a search: failures, statistics of the attempts, and gaps."""

from __future__ import annotations

import hashlib
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from hmrsim.fault_search.run import Failure, Outcome
    from hmrsim.fault_search.schedule import Case, Injection, Schedule

_FEW: Final = 50
"""A search with fewer runs is too short, unless nothing is left to try."""


@dataclass(frozen=True)
class Unreached:
    """The gaps of a search: injections, properties and nodes without a run.

    Attributes:
        singles: Single injections at single moments that were not tried for lack of time.
        kinds: Kinds of injections that were tried and never began.
        untried: Kinds of injections that can happen here and were not tried.
        properties: Properties that no run has exercised.
        nodes: Statuses that nodes of the tree had in no run.
    """

    singles: int = 0
    kinds: tuple[str, ...] = ()
    untried: tuple[str, ...] = ()
    properties: tuple[str, ...] = ()
    nodes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Summary:
    """The result of a search.

    Attributes:
        nominal: The outcome of the run without faults.
        findings: The failures, in the order in which they were found.
        exercised: The number of runs that exercised each property, by name.
        seconds: The wall seconds of the search.
        complete: Whether the search was not interrupted.
        first_only: Whether the search was to end with its first failure.
        kept: The number of schedules that exercised something new.
        features: The number of different features that were exercised.
        covered: The coverage of the tree, in words; empty without a tree.
        files: The file that reproduces each failure, by its number from 1.
    """

    name: str
    seed: int
    nominal: Outcome
    findings: Sequence[Finding]
    tried: Tried
    exercised: Mapping[str, int]
    unreached: Unreached
    seconds: float
    complete: bool = True
    first_only: bool = False
    kept: int = 0
    features: int = 0
    covered: str = ""
    files: dict[int, str] = field(default_factory=dict)

    @property
    def too_few(self) -> bool:
        """True if there were too few runs for a conclusion: a kind or most injections had no turn."""
        if self.first_only and self.findings:
            return False
        tried = self.tried
        return tried.singles_left > 0 and (bool(self.unreached.untried) or tried.runs < _FEW)

    def to_json(self) -> dict[str, Any]:
        """Return it as JSON values."""
        tried = self.tried
        return {
            "name": self.name,
            "seed": self.seed,
            "complete": self.complete,
            "seconds": round(self.seconds, 3),
            "runs": tried.runs,
            "too_few": self.too_few,
            "gave_up": {"runs": tried.gave_up, "of": tried.transient, "first": self.gave_up_first},
            "failed": tried.failed,
            "endings": dict(sorted(tried.endings.items())),
            "kinds": {kind: {"tried": tried.kinds[kind], "began": tried.begun[kind]} for kind in sorted(tried.kinds)},
            "exercised": dict(self.exercised),
            "features": self.features,
            "covered": self.covered,
            "unreached": asdict(self.unreached),
            "nominal": {"ending": self.nominal.ending, "at": self.nominal.at},
            "findings": [self._finding(number, each) for number, each in enumerate(self.findings, 1)],
        }

    @property
    def gave_up_first(self) -> list[str]:
        """The first schedule with only transient faults after which the controller gave up, in words."""
        return [injection.describe() for injection in self.tried.gave_up_first]

    def _finding(self, number: int, finding: Finding) -> dict[str, Any]:
        return {
            "property": finding.failure.property,
            "reason": finding.failure.reason,
            "text": finding.text,
            "run": finding.run,
            "seconds": round(finding.seconds, 3),
            "reducing": round(finding.reducing, 3),
            "known": finding.known,
            "runs": finding.seen,
            "schedule": [dict(injection.spec) for injection in finding.schedule],
            "things": [injection.describe() for injection in finding.schedule],
            "file": self.files.get(number, ""),
        }


@dataclass(frozen=True)
class Reduced:
    """A reduced case; its schedule is 1-minimal if there was time for that.

    Attributes:
        without: For each injection of its schedule, the outcome of the case without it; its ending is ``not_run`` if
            time ran out.
        runs: The number of runs that the reduction took.
    """

    case: Case
    without: tuple[Outcome, ...]
    runs: int


@dataclass(frozen=True)
class Finding:
    """A failure that a search found.

    Attributes:
        run: The number of the first run with this failure, from 1.
        original: The schedule of this run.
        outcome: The outcome of the reduced case, with its trace and its events.
        seconds: The wall seconds after which it was found.
        reducing: The wall seconds of its reduction.
        known: Whether an earlier search found it, and it is in the folder of the results.
        seen: The number of runs that failed like this.
    """

    failure: Failure
    run: int
    original: Schedule
    reduced: Reduced
    outcome: Outcome
    seconds: float
    reducing: float = 0.0
    known: bool = False
    seen: int = 1

    @property
    def case(self) -> Case:
        """The case after its reduction."""
        return self.reduced.case

    @property
    def schedule(self) -> Schedule:
        """The schedule of the reduced case."""
        return self.reduced.case.schedule

    @property
    def without(self) -> Sequence[Outcome]:
        """The outcome of the case without each injection of the schedule."""
        return self.reduced.without

    @property
    def in_order(self) -> list[tuple[Injection, Outcome]]:
        """The injections in the order in which they began, each with the outcome of the case without it."""
        return [(self.schedule[i], self.without[i]) for i in by_begin(self.schedule, self.outcome)]

    @property
    def text(self) -> str:
        """The violation as a sentence."""
        return next(
            (each.text for each in self.outcome.violations if (each.property, each.reason) == self.failure),
            self.failure.reason,
        )

    @property
    def trace_hash(self) -> str:
        """The SHA-256 of the trace."""
        return hashlib.sha256(self.outcome.trace.encode()).hexdigest() if self.outcome.trace else ""


def by_begin(schedule: Schedule, outcome: Outcome) -> list[int]:
    """Return the indices of a schedule's injections in the order in which they began, the others last."""
    began = dict(enumerate(outcome.began))
    return sorted(range(len(schedule)), key=lambda i: math.inf if (at := began.get(i)) is None else at)


@dataclass
class Tried:
    """Statistics of the schedules that a search has tried.

    Attributes:
        failed: The number of runs that violated a property.
        singles: The number of single injections, each at each moment.
        singles_left: The number of these that were not tried.
        kinds: The number of injections in schedules, by kind.
        begun: The number of these that began, by kind.
        transient: The number of runs with transient faults only.
        gave_up: The number of these in which the controller ended as failed.
        gave_up_first: The schedule of the first of these.
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
