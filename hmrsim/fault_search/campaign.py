"""A campaign: the run without faults, earlier failures, batches of schedules, and the reduction of failures."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

from hmrsim.fault_search.candidates import Candidates
from hmrsim.fault_search.reducer import Reducer
from hmrsim.fault_search.run import NOT_RUN
from hmrsim.fault_search.schedule import Case
from hmrsim.fault_search.search import Found, Search, Strategy
from hmrsim.fault_search.summary import Finding, Summary, Unreached
from hmrsim.trials.trial import CRASHED, DIED, ERROR, FAILED, MEMORY, SUCCEEDED

if TYPE_CHECKING:
    from hmrsim.fault_search.check import Check
    from hmrsim.fault_search.evaluator import Evaluator
    from hmrsim.fault_search.run import Failure, Outcome

_ENDS_OF_ITS_OWN: Final = (SUCCEEDED, FAILED, CRASHED, DIED, MEMORY)
_LONGER: Final = 10.0
_MORE: Final = 600.0
"""The default limit of a run is its time without faults times `_LONGER`, plus this number of simulated seconds."""
_REDUCING: Final = 0.3
"""The share of the time budget that the reduction of a failure may take."""
_LEAST: Final = 10.0
"""Without a time budget, a reduction may take this number of wall seconds, or the time of the search if longer."""
_TELLING: Final = 2.0
"""Wall seconds for the run of a story even if time is over."""
_RESERVE: Final = 0.1
_MAX_RESERVE: Final = 10.0
"""This share of the budget, at most this number of wall seconds, is kept for failures found at the end."""


def limited(check: Check, nominal: Outcome) -> Check:
    """Return a check with the reference and the limit that follow from its run without faults.

    Without a limit of its own, its runs may take ten times as long, plus ten minutes. They are compared with the run
    without faults if that has succeeded.
    """
    reference = nominal.items if nominal.ending == "succeeded" else None
    limit = check.limit
    if check.file.limits.simulated is None and nominal.ending in {"succeeded", "failed"}:
        limit = round(nominal.at * _LONGER + _MORE, 3)
    return replace(check, limit=limit, reference=reference)


def no_search(nominal: Outcome) -> str:
    """Return the reason why a search is pointless after a run without faults; empty if it is not."""
    if nominal.ending == ERROR:
        return nominal.cause
    if nominal.ending in _ENDS_OF_ITS_OWN and not nominal.moments:
        cause = nominal.cause or nominal.output.rpartition("\n")[2]
        if nominal.ending == SUCCEEDED:
            cause = cause or "does the controller await what it calls?"
        how = f"without any fault the run ends as {nominal.ending} at {nominal.at:.1f} s, before a goal is sent"
        return f"{how}{f': {cause}' if cause else ''}; there is nothing that a fault could break"
    return ""


@dataclass
class Progress:
    """The progress of a search.

    Attributes:
        seconds: Wall seconds that have passed.
        left: Wall seconds left for the current step.
        reducing: The property whose failure is being reduced; empty while the search goes on.
        reduced_in: The number of runs of this reduction so far.
    """

    search: Search
    findings: Sequence[Finding]
    seconds: float
    left: float
    reducing: str = ""
    reduced_in: int = 0


@dataclass
class Options:
    """The options of a search.

    Attributes:
        strategy: ``guided``, or ``random`` for comparison.
        earlier: Earlier failures, each with its case, which are run first.
        set_aside: Called with an earlier failure that no longer occurs because its world does not suit the
            controller, and with the reason.
        tell: Called with the progress, batch by batch, of the search and of reductions.
        on_finding: Called with each failure once it is reduced.
    """

    strategy: Strategy = "guided"
    first_only: bool = False
    reduce: bool = True
    earlier: Sequence[tuple[Case, Failure]] = ()
    set_aside: Callable[[Case, str], None] = lambda _case, _why: None
    tell: Callable[[Progress], None] = lambda _progress: None
    on_finding: Callable[[Finding], None] = lambda _finding: None


class Campaign:
    """Searches for failures of a check within its budget, and reduces them.

    Args:
        check: The check, with its limit.
        nominal: The outcome of the run without faults.
        began: The start of the budget, by the monotonic clock; None for now.
    """

    def __init__(
        self, check: Check, evaluator: Evaluator, nominal: Outcome, options: Options, began: float | None = None
    ) -> None:
        self._check, self._evaluator, self._nominal, self._options = check, evaluator, nominal, options
        self._candidates = Candidates(check.world, check.file.space, nominal.moments, dict(nominal.draws))
        self._search = Search(check, evaluator, self._candidates, nominal, options.strategy)
        self._began = time.monotonic() if began is None else began
        self._until = self._began + check.file.budget.time
        self._reducing = 0.0
        self._findings: list[Finding] = []
        self._interrupted = False

    def run(self) -> Summary:
        """Search until the budget is used up, nothing is left to try, or it is interrupted by Ctrl-C."""
        try:
            self._run()
        except KeyboardInterrupt:
            self._interrupted = True
        return self.summary()

    def _run(self) -> None:
        one, until = self._options.first_only, self._searches_until
        self._take(self._search.run([Case(), *self._fitting(until)], until, one=one))
        while not self._ended():
            found = self._search.next(self._runs_left(), until, one=one)
            if found is None:
                return
            self._take(found)
            self._tell()

    def _fitting(self, until: float) -> list[Case]:
        """Return the cases of earlier failures that suit the controller.

        A world reduced for one controller may lack objects that another needs, which then fails even without the
        schedule.
        """
        fitting = []
        for case, failure in self._options.earlier:
            here, alone = case, case.with_schedule(())
            outcomes = self._evaluator.outcomes([here, alone], until)
            if len(outcomes) < 2:  # noqa: PLR2004 - both
                break
            outcome, nominal = outcomes
            if ERROR in (outcome.ending, nominal.ending):
                self._options.set_aside(case, outcome.cause or nominal.cause)
            elif outcome.failure is None or failure in outcome.failures:
                fitting.append(case)
            elif nominal.ending != self._nominal.ending:
                how = f"without its schedule the run ends as {nominal.ending}"
                self._options.set_aside(case, f"{how}{f': {nominal.cause}' if nominal.cause else ''}")
            else:
                fitting.append(case)
        return fitting

    def _ended(self) -> bool:
        done = self._interrupted or (self._options.first_only and bool(self._findings))
        return done or self._left() <= 0 or self._runs_left() <= 0

    def _left(self) -> float:
        return self._searches_until - time.monotonic()

    @property
    def _searches_until(self) -> float:
        return self._until - min(_MAX_RESERVE, _RESERVE * self._check.file.budget.time)

    def _runs_left(self) -> int:
        most = self._check.file.budget.runs
        return 10**9 if most is None else most - self._search.tried.runs

    def _tell(self) -> None:
        seconds = time.monotonic() - self._began
        self._options.tell(Progress(self._search, self._findings, seconds, max(0.0, self._left())))

    def _take(self, found: Sequence[Found]) -> None:
        for each in found:
            if self._interrupted or (self._options.first_only and self._findings):
                return
            finding = self._reduced(each)
            self._findings.append(finding)
            self._search.pass_over(finding.schedule)
            self._options.on_finding(finding)

    def _reduced(self, found: Found) -> Finding:
        """Return a failure for the user: reduced, with its trace and its events."""
        began = time.monotonic()
        until = self.reduces_until(began)
        runs = self._evaluator.runs

        def over() -> bool:
            now = time.monotonic()
            left, made = max(0.0, until - now), self._evaluator.runs - runs
            self._options.tell(
                Progress(self._search, self._findings, now - self._began, left, found.failure.property, made)
            )
            return self._interrupted or not self._options.reduce or now > until

        reducer = Reducer(
            self._evaluator, self._check.definition, self._nominal, over, until, self._check.named, self._check.world
        )
        try:
            reduced = reducer.reduce(found.case, found.failure)
        except KeyboardInterrupt:
            # The failure is kept: after an interrupt it gets only the few runs that every failure needs.
            self._interrupted = True
            self._evaluator.stop()
            reduced = reducer.reduce(found.case, found.failure)
        outcome = self._evaluator.rerun(reduced.case, max(until, time.monotonic() + _TELLING))
        if outcome.ending == NOT_RUN:
            outcome = found.outcome
        self._reducing += time.monotonic() - began
        known = any(case.key == found.case.key for case, _ in self._options.earlier)
        seconds = began - self._began
        return Finding(
            found.failure,
            found.run,
            found.case.schedule,
            reduced,
            outcome,
            seconds,
            time.monotonic() - began,
            known=known,
        )

    def reduces_until(self, now: float) -> float:
        """Return the last moment of a reduction that begins now, by the monotonic clock."""
        budget = self._check.file.budget
        if "time" in budget.model_fields_set or budget.runs is None:
            return min(self._until, now + _REDUCING * budget.time)
        return min(self._until, now + max(_LEAST, now - self._began - 2 * self._reducing))

    def summary(self) -> Summary:
        """Return the results of the search so far."""
        search = self._search
        properties = {verdict.property: search.tried.exercised[verdict.property] for verdict in self._nominal.verdicts}
        kinds = dict.fromkeys(candidate.injection.kind for candidate in self._candidates.entries)
        unreached = Unreached(
            search.tried.singles_left,
            tuple(kind for kind in kinds if search.tried.kinds[kind] and not search.tried.begun[kind]),
            tuple(kind for kind in kinds if not search.tried.kinds[kind]),
            tuple(name for name, count in properties.items() if not count),
            self._evaluator.covered.never(),
        )
        seen = search.seen_failures
        return Summary(
            self._check.name,
            self._check.file.seed,
            self._nominal,
            [replace(each, seen=seen[each.failure]) for each in self._findings],
            search.tried,
            properties,
            unreached,
            time.monotonic() - self._began,
            not self._interrupted,
            self._options.first_only,
            len(search.guide.kept),
            len(search.guide.features),
            self._evaluator.covered.share,
        )
