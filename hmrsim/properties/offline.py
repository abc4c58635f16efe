"""Checks of runs that are over: from a trace, or from a recording."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from hmrsim.engine.sim_time import stamp
from hmrsim.errors import TraceError, WorldError
from hmrsim.history.occurrence import LATEST, Malformed
from hmrsim.properties.model.checks import check_properties
from hmrsim.properties.monitor import Monitor, MonitorSink
from hmrsim.properties.results import Ended
from hmrsim.report.reading import header_of, occurrence_in, sampled
from hmrsim.trace.replay import replay
from hmrsim.trace.sections import begins_section
from hmrsim.world_checks.loading import world_of

if TYPE_CHECKING:
    from hmrsim.diagnostics import Finding
    from hmrsim.history.occurrence import Occurrence
    from hmrsim.properties.model.file import Properties
    from hmrsim.report.reading import Recorded
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.trace.replay import Outcome
    from hmrsim.world.model import World

_Watched = tuple[Monitor, tuple[str, ...]]

_CUT_OFF = Ended("stopped")
"""The end of a run whose file does not have it."""


@dataclass(frozen=True)
class Checked:
    """The check of a run.

    Attributes:
        monitor: The monitor, with the verdicts.
        findings: The parts of properties that do not fit the world.
        notes: Notes on how the run was read, and on its gaps.
    """

    monitor: Monitor
    findings: list[Finding]
    notes: tuple[str, ...] = ()


def check_trace(
    lines: Callable[[], Iterable[str]],
    properties: Properties,
    found: Callable[[list[Finding]], object] = lambda _findings: None,
) -> Checked:
    """Check the run of a trace, all its sections one after the other, by replaying it.

    If it can't be replayed exactly, only its own lines are used.

    Args:
        lines: Returns its lines with their ends, from the first one; called up to three times.
        properties: The properties.
        found: Called with the findings before the run is read, which may take long.

    Raises:
        TraceError: It is not a trace.
    """
    world = _world(header_of(next(iter(lines()), ""))["world"]["definition"])
    findings = check_properties(properties, world)
    found(findings)
    monitor, notes = _watched(lines, properties, world)
    return Checked(monitor, findings, notes)


def _watched(lines: Callable[[], Iterable[str]], properties: Properties, world: World) -> _Watched:
    """Return the monitor after it has read a trace, and notes about the trace."""
    replayed = _Replayed(properties, world)
    try:
        outcome = replay(lines(), replayed.watch)
    except TraceError as error:
        return _as_written(lines(), properties, world, f"this version can't replay it ({error})")
    if outcome.difference is not None:
        why = f"the replay differs from line {outcome.difference.line} on"
        return _as_written(lines(), properties, world, why)
    return replayed.checked(outcome)


class _Replayed:
    """A replay that is watched by one monitor."""

    def __init__(self, properties: Properties, world: World) -> None:
        self._monitor = Monitor(properties, world)
        self._sinks: list[MonitorSink] = []

    def watch(self, simulator: Simulator) -> list[MonitorSink]:
        """Return the sinks of a simulator."""
        self._sinks.append(MonitorSink(simulator, self._monitor))
        return self._sinks

    def checked(self, outcome: Outcome) -> _Watched:
        """Return the monitor at the end of the replay, and notes."""
        for sink in self._sinks:
            sink.sample_batteries()
        self._monitor.end(stamp(outcome.sections[-1].sim_time), None if outcome.complete else _CUT_OFF)
        notes = () if outcome.complete else ("The trace is truncated: later events are missing.",)
        return self._monitor, notes


def _as_written(lines: Iterable[str], properties: Properties, world: World, why: str) -> _Watched:
    monitor, last, misfits = Monitor(properties, world), "", 0
    monitor.begin(0)
    for number, line in enumerate(lines, 1):
        if not line.endswith("\n") or number == 1 or begins_section(line):
            continue
        occurrence, last = occurrence_in(line, f"line {number}")
        misfits += not _fits(monitor, occurrence)
    complete = last == "end"
    monitor.end(None, None if complete else _CUT_OFF)
    notes = [f"The trace could not be replayed exactly ({why}): where robots drive and how batteries empty is missing."]
    if not complete:
        notes.append("The trace is truncated: later events are missing.")
    return monitor, (*notes, *_note(misfits))


def _fits(monitor: Monitor, occurrence: Occurrence) -> bool:
    """Give an occurrence to a monitor; return whether it is valid, as files may have any content."""
    try:
        monitor.take(occurrence)
    except ValueError:
        return False
    return not isinstance(occurrence.event, Malformed)


def _note(misfits: int) -> Iterator[str]:
    if misfits:
        yield f"{misfits} events are ignored, as this version can't read them."


def check_recording(
    recording: Recorded,
    properties: Properties,
    found: Callable[[list[Finding]], object] = lambda _findings: None,
) -> Checked:
    """Check the run of a recording; *found* is as that of `check_trace`.

    Raises:
        TraceError: Its world can't be read.
    """
    world = _world(recording.world)
    findings = check_properties(properties, world)
    found(findings)
    monitor, misfits = Monitor(properties, world), 0
    for _, key, payload in recording.samples():
        occurrence = sampled(key, payload)
        if occurrence is not None:
            misfits += not _fits(monitor, occurrence)
    monitor.begin(0)
    # Time continues after the last event, but a damaged file may have any end.
    if monitor.timeline.now < recording.end <= LATEST:
        monitor.timeline.advance(recording.end)
    truncated = recording.truncated
    monitor.end(None, _CUT_OFF if truncated else None)
    notes = ("The recording is truncated: later events are missing.",) if truncated else ()
    return Checked(monitor, findings, (*notes, *_note(misfits)))


def _world(definition: Any) -> World:
    try:
        return world_of(dict(definition), "world")
    except (WorldError, TypeError, ValueError) as error:
        raise TraceError(f"its world can't be read: {error}") from None
