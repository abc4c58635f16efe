"""One run of a schedule: a disturbed trial, with the monitors of its properties, and its outcome."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple

from bt_controller.coverage import TreeCoverage
from hmrsim.engine.sim_time import stamp
from hmrsim.events.simulation import ParticipantDropped
from hmrsim.fault_search.observer import BatteryDraws, Observer, new_coverage
from hmrsim.fault_search.schedule import DISTURBANCE, FAULT
from hmrsim.properties import Ended, Monitor, MonitorSink
from hmrsim.properties.results import reference_of
from hmrsim.simulation.snapshot import scene
from hmrsim.timing.pacing import Watchers, unwatched
from hmrsim.trace.writer import DeferredTrace
from hmrsim.trials.controllers import trial_of
from hmrsim.trials.disturbances import Disturbance, Disturber
from hmrsim.trials.guards import attempt
from hmrsim.trials.trial import CRASHED, ERROR, FAILED, HUNG, KILLED, SUCCEEDED, TIMEOUT
from hmrsim.world_checks import LoadedWorld

if TYPE_CHECKING:
    from hmrsim.fault_search.check import Check
    from hmrsim.fault_search.kinds import Draw
    from hmrsim.fault_search.schedule import Case, Moment
    from hmrsim.properties import Properties, Verdict, Violation
    from hmrsim.properties.results import Reference
    from hmrsim.protocol.outputs import EventStamped
    from hmrsim.protocol.sinks import Sink
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.timing.pacing import Pacing
    from hmrsim.trials.controllers import OnTick

Ending = tuple[str, str]
"""The ending of a run and its cause."""

_KILLING: Final = ("controller_killed", "second_controller")
"""Disturbances that kill a controller on purpose; a second controller is killed when the first one ends."""

_REFUSED: Final = "NotServed:"
"""The start of the cause if a tree ends at its start, since its robot can't be reached or lacks an action."""


@dataclass(frozen=True)
class Wanted:
    """The outputs of a run besides its verdicts.

    Attributes:
        story: Whether to return its events in words.
        further: Makes further sinks, such as one that records the run.
        on_tick: Called after each tick of a tree, if given.
    """

    trace: bool = False
    story: bool = False
    further: Watchers = unwatched
    on_tick: OnTick | None = None


VERDICTS = Wanted()
"""The verdicts alone."""


def run_case(check: Check, case: Case, wanted: Wanted = VERDICTS) -> Outcome:
    """Run a case and return its outcome."""
    outcome = run_within(check, case, wanted, math.inf)
    if outcome is None:
        raise AssertionError
    return outcome


def run_within(check: Check, case: Case, wanted: Wanted, seconds: float) -> Outcome | None:
    """Run a case; return its outcome, or None if it takes longer than *seconds* of wall time."""
    outcome, _, wall = attempt(
        check.file.limits, lambda: _Run(check, case, wanted).outcome(), partial(without_run, check, case), seconds
    )
    return None if outcome.ending == HUNG and wall >= seconds else replace(outcome, wall=wall)


def without_run(check: Check, case: Case, ending: str, cause: str) -> Outcome:
    """Return the outcome of a run that was not judged to its end, with the violations by its ending alone.

    Raises:
        WorldError: The case can't be made.
    """
    if ending == ERROR:
        return Outcome(ERROR, cause)
    monitor = Monitor(check.properties, check.world_of(case), check.reference)
    monitor.end(0, Ended(ending, cause))
    return Outcome(ending, cause, 0.0, tuple(monitor.violations), tuple(monitor.verdicts()))


class _Run:
    """One run of a case."""

    def __init__(self, check: Check, case: Case, wanted: Wanted) -> None:
        self._check, self._case, self._wanted = check, case, wanted
        self._world = check.world_of(case)
        self._settings = check.settings
        self._monitor = Monitor(_applicable(check.properties, case), self._world, check.reference)
        self._observer = Observer(story=wanted.story)
        self._battery_draws: BatteryDraws | None = None
        self._simulator: Simulator | None = None
        self._trace = DeferredTrace(self._world, self._settings) if wanted.trace else None
        self._coverage = TreeCoverage() if check.treatment.tree is not None else None
        self._disturber = Disturber(
            [
                Disturbance.model_validate(dict(injection.spec))
                for injection in case.schedule
                if injection.family == DISTURBANCE
            ],
            self._observer.note_disturbance,
        )
        self._end: Callable[[str], None] = lambda _reason: None
        self._output = ""
        self._fatal = False

    def outcome(self) -> Outcome:
        """Execute the run and return its outcome."""
        ending, cause, now = self._ended()
        compared = self._simulator if self._check.compares and not self._case.schedule else None
        self._monitor.end(now, Ended(ending, cause))
        observer, coverage = self._observer, self._coverage
        covered = coverage.keys() if coverage else frozenset[str]()
        return Outcome(
            ending,
            cause,
            now / 1e9,
            tuple(self._monitor.violations),
            tuple(self._monitor.verdicts()),
            (*observer.features, *sorted(covered)),
            tuple(observer.moments),
            self._began(),
            aborts=observer.aborts,
            trace=self._trace.whole(now / 1e9) if self._trace else "",
            story=tuple(observer.lines),
            output=self._output,
            coverage=new_coverage(self._check.hash, coverage, covered) if coverage else b"",
            draws=self._battery_draws.finish() if self._battery_draws else (),
            items=reference_of(scene(compared)) if compared else None,
        )

    def _ended(self) -> tuple[str, str, int]:
        """Make the run; return its ending, the cause, and its time in nanoseconds."""
        check = self._check
        trial = trial_of(
            LoadedWorld(self._world, Path(check.place), ()),
            self._settings,
            check.treatment,
            check.folder,
            variables={"HMRSIM_RUN": self._case.key[:16]},
            coverage=self._coverage,
            watchers=self._watchers,
            disturber=self._disturber,
            on_tick=self._wanted.on_tick,
        )
        self._end = trial.end
        with trial:
            ending, cause, self._output = trial.play()
        return *self._judged(ending, cause, over=trial.over), stamp(trial.simulator.now)

    def _watchers(self, simulator: Simulator, pacing: Pacing) -> list[Sink]:
        """Return the sinks of the run, in the order in which they receive outputs."""
        self._simulator = simulator
        killed = any(each.disturbance in _KILLING for each in self._disturber.disturbances)
        monitors = ExcusingSink if killed else MonitorSink
        own: list[Sink] = [monitors(simulator, self._monitor, self._note), self._observer]
        if not self._case.schedule:
            self._battery_draws = BatteryDraws(simulator, self._world)
            own.append(self._battery_draws)
        if self._disturber.disturbances:
            own.append(self._disturber.watch(simulator, pacing))
        return [*([self._trace] if self._trace else []), *own, *self._wanted.further(simulator, pacing)]

    def _judged(self, ending: str, cause: str, *, over: bool) -> Ending:
        """Return the ending of a run; one that was over before its controller ended by a violation or its limit."""
        if ending == KILLED:
            # A disturbance killed it for good, so it did not fail.
            return "stopped", cause
        if ending == CRASHED and cause.startswith(_REFUSED):
            return FAILED, cause
        if over and ending in {SUCCEEDED, FAILED, CRASHED}:
            return ("stopped" if self._fatal else TIMEOUT), ""
        return ending, cause

    def _note(self, violation: Violation) -> None:
        if violation.fatal:
            self._fatal = True
            self._end(f"{violation.property}: {violation.text}")

    def _began(self) -> tuple[float | None, ...]:
        """Return when each injection of the schedule began; None for a fault or disturbance that never did."""
        faults = {key: iter(times) for key, times in self._observer.begun.items()}
        disturbances = iter(self._disturber.began)
        began: list[float | None] = []
        for injection in self._case.schedule:
            if injection.family == FAULT:
                began.append(next(faults.get((injection.kind, injection.subject), iter(())), None))
            else:
                began.append(next(disturbances) if injection.family == DISTURBANCE else 0.0)
        return tuple(began)


def _applicable(properties: Properties, case: Case) -> Properties:
    """Return the properties of a case: without `recovers` if its schedule has more than transient faults."""
    if not properties.built_in.recovers or all(injection.transient for injection in case.schedule):
        return properties
    return properties.model_copy(update={"built_in": properties.built_in.model_copy(update={"recovers": False})})


NOT_RUN: Final = "not_run"
"""The ending of a case that was not run for lack of time."""


class Failure(NamedTuple):
    """A failure of a run; runs with equal failures failed for the same reason.

    Attributes:
        reason: The reason, as a stable text without times and names.
    """

    property: str
    reason: str

    def __str__(self) -> str:
        """Return both as text."""
        return f"{self.property}: {self.reason}"


@dataclass(frozen=True)
class Outcome:
    """The outcome of a run.

    Attributes:
        ending: The ending: ``succeeded``, ``failed``, ``timeout``, ``crashed``, ``hung``, ``deadlock``, ``died``,
            ``error`` and others of an experiment's endings.
        cause: Details that the ending lacks.
        at: The time of its end, in simulated seconds.
        violations: The violations of properties, in order of time.
        features: The features of the run, as texts, to guide the search.
        moments: The moments to which injections may be anchored.
        began: The time at which each injection of its schedule began, in simulated seconds; None if it never began, 0
            for changes.
        aborts: The reasons for which goals were aborted or rejected, each once.
        wall: The wall seconds that it took.
        story: Its events in words, each with its time in seconds, if requested.
        output: The last lines that a command printed.
        coverage: The packed coverage of the tree; empty if nothing in it is new to the worker.
        items: The items at the end of a run without a schedule, if other runs are compared with it.
        draws: The battery draw of each robot in a run without a schedule.
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


class ExcusingSink(MonitorSink):
    """A monitor sink for runs that kill the controller on purpose, so that this does not count as a failure."""

    def _take(self, output: EventStamped) -> None:
        """Pass events on, except that a participant was dropped: then the monitor expects a new controller."""
        if isinstance(output.event, ParticipantDropped):
            self._monitor.replace_controller()
        else:
            super()._take(output)
