"""Checks of runs that are over: from a trace, or from a recording."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

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
    from hmrsim.world.model import World

_CUT_OFF: Final = Ended("stopped")
"""The end of a run whose file does not have it."""
_TRUNCATED: Final = "The {} is truncated: later events are missing."


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

    If it can't be replayed exactly, only its own lines are used. *lines* returns them with their ends, from the first
    one, and is called up to three times. *found* is called with the findings before the run is read, which may take
    long.

    Raises:
        TraceError: It is not a trace.
    """
    world, findings = _fitted(header_of(next(iter(lines()), ""))["world"]["definition"], properties, found)
    monitor, sinks = Monitor(properties, world), list[MonitorSink]()

    def watch(simulator: Simulator) -> list[MonitorSink]:
        sinks.append(MonitorSink(simulator, monitor))
        return sinks

    try:
        outcome = replay(lines(), watch)
    except TraceError as error:
        return _as_written(lines(), properties, world, findings, f"this version can't replay it ({error})")
    if outcome.difference is not None:
        why = f"the replay differs from line {outcome.difference.line} on"
        return _as_written(lines(), properties, world, findings, why)
    for sink in sinks:
        sink.sample_batteries()
    monitor.end(stamp(outcome.sections[-1].sim_time), None if outcome.complete else _CUT_OFF)
    return Checked(monitor, findings, () if outcome.complete else (_TRUNCATED.format("trace"),))


def _as_written(
    lines: Iterable[str], properties: Properties, world: World, findings: list[Finding], why: str
) -> Checked:
    """Return the check of a trace by its lines alone."""
    monitor, last, misfits = Monitor(properties, world), "", 0
    monitor.begin(0)
    for number, line in enumerate(lines, 1):
        if line.endswith("\n") and number > 1 and not begins_section(line):
            occurrence, last = occurrence_in(line, f"line {number}")
            misfits += not _fits(monitor, occurrence)
    complete = last == "end"
    monitor.end(None, None if complete else _CUT_OFF)
    notes = [f"The trace could not be replayed exactly ({why}): where robots drive and how batteries empty is missing."]
    if not complete:
        notes.append(_TRUNCATED.format("trace"))
    return Checked(monitor, findings, (*notes, *_note(misfits)))


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
    world, findings = _fitted(recording.world, properties, found)
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
    notes = (_TRUNCATED.format("recording"),) if truncated else ()
    return Checked(monitor, findings, (*notes, *_note(misfits)))


def _fitted(
    definition: Any, properties: Properties, found: Callable[[list[Finding]], object]
) -> tuple[World, list[Finding]]:
    """Return the world of a run, and the parts of properties that do not fit it."""
    try:
        world = world_of(dict(definition), "world")
    except (WorldError, TypeError, ValueError) as error:
        raise TraceError(f"its world can't be read: {error}") from None
    findings = check_properties(properties, world)
    found(findings)
    return world, findings
