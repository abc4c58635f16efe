"""The summary of a search: what was found, what was tried, and what was not reached."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from hmrsim.fault_search.results.finding import Finding
    from hmrsim.fault_search.results.tried import Tried
    from hmrsim.fault_search.running.outcome import Outcome


_FEW: Final = 50
"""Runs that are too few for a search, unless nothing is left to try."""


@dataclass(frozen=True)
class Unreached:
    """What a search has not reached.

    Attributes:
        singles: Single things at single moments that were not tried for lack of time.
        kinds: Kinds of things that were tried and never began.
        untried: Kinds of things that can happen here and were not tried.
        properties: Properties that no run has exercised.
        nodes: What no run has made the nodes of the tree do.
    """

    singles: int = 0
    kinds: tuple[str, ...] = ()
    untried: tuple[str, ...] = ()
    properties: tuple[str, ...] = ()
    nodes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Summary:
    """What came of a search.

    Attributes:
        name: The name of the check.
        seed: Of the search.
        nominal: What came of the run without faults.
        findings: The failures, in the order in which they were found.
        tried: What was tried.
        exercised: In how many runs each property was exercised, by name.
        unreached: What was not reached.
        seconds: Wall seconds that it took.
        complete: Whether it has ended by its budget, and was not interrupted.
        kept: How many schedules have exercised something new.
        features: How many different things were exercised.
        covered: How much of the tree was ticked, in words; empty without a tree.
        files: The file that repeats each failure, by its number from 1.
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
    kept: int = 0
    features: int = 0
    covered: str = ""
    files: dict[int, str] = field(default_factory=dict)

    @property
    def too_few(self) -> bool:
        """Whether there were far too few runs to say anything: a kind had no turn, or few things had one."""
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
            "unreached": {
                "singles": self.unreached.singles,
                "kinds": list(self.unreached.kinds),
                "untried": list(self.unreached.untried),
                "properties": list(self.unreached.properties),
                "nodes": list(self.unreached.nodes),
            },
            "nominal": {"ending": self.nominal.ending, "at": self.nominal.at},
            "findings": [self._finding(number, each) for number, each in enumerate(self.findings, 1)],
        }

    @property
    def gave_up_first(self) -> list[str]:
        """The first schedule of transient faults only after which the controller gave up, in words."""
        return [thing.describe() for thing in self.tried.gave_up_first]

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
            "schedule": [dict(thing.said) for thing in finding.schedule],
            "things": [thing.describe() for thing in finding.schedule],
            "file": self.files.get(number, ""),
        }
