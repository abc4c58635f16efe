"""Reading a trace or a recording into the stories of its sections; no other file is read."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, Final, Protocol

from pydantic_core import from_json

from hmrsim import __version__
from hmrsim.components.battery import voltage_at
from hmrsim.engine.sim_time import stamp
from hmrsim.errors import TraceError
from hmrsim.history.occurrence import (
    LATEST,
    BatterySeen,
    Misfit,
    Occurrence,
    SceneSeen,
    number,
    occurrence_of,
    text,
    time_of,
)
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.report.compile import ReportInput, notes_of
from hmrsim.report.model import Source
from hmrsim.report.sink import ReportSink
from hmrsim.report.story import Story
from hmrsim.trace.replay import replay
from hmrsim.trace.sections import begins_section, check_section

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.trace.replay import Outcome


def of_trace(lines: Callable[[], Iterable[str]], *, section: int | None = None) -> list[ReportInput]:
    """Return the content of each section of a trace, or of one, by replaying it.

    From the section on in which the replay differs, it is made from the lines alone.

    Args:
        lines: Returns its lines with their ends, from the first one; called up to three times. A last line without
            an end is incomplete, and left out.
        section: The only one that is wanted; all if None.

    Raises:
        TraceError: It is not a trace, or has no such section.
    """
    header_of(next(iter(lines()), ""))
    if section is not None:
        check_section(lines(), section)
    stories = _Stories()
    try:
        outcome = replay(lines(), stories.watch, section=section)
    except TraceError as error:
        found = as_written(lines(), f"this version can't replay it ({error})")
    else:
        found = stories.contents(outcome)
        if outcome.difference is not None:
            same = len(outcome.sections) - 1
            why = f"the replay differs from line {outcome.difference.line} on"
            found = [*found[:same], *as_written(lines(), why)[same:]]
    return found if section is None else [found[section - 1]]


class _Stories:
    """The stories of a replay, one a section."""

    def __init__(self) -> None:
        self._all = [Story()]
        self._sinks: list[ReportSink] = []

    def watch(self, simulator: Simulator) -> list[ReportSink]:
        """Return the sink that tells them."""
        self._sinks.append(ReportSink(simulator, self._take, self._begin))
        return self._sinks

    def _take(self, occurrence: Occurrence) -> None:
        self._all[-1].take(occurrence)

    def _begin(self, ended: int) -> None:
        self._all[-1].end(ended)
        self._all.append(Story())

    def contents(self, outcome: Outcome) -> list[ReportInput]:
        """Return the content of each section that was replayed; the last one ends there."""
        if len(outcome.sections) == len(self._all):
            self._sinks[0].weigh_all()
            self._all[-1].end(stamp(outcome.sections[-1].sim_time))
        found = []
        for story, section in zip(self._all, outcome.sections, strict=False):
            header = from_json(section.header.line())
            complete = outcome.complete or section is not outcome.sections[-1]
            notes = () if complete else ("The trace is truncated: later events are missing.",)
            source = Source(kind="trace", exact=True, complete=complete, notes=(*notes, *notes_of(story)))
            found.append(ReportInput(story, source, header, header["world"]["definition"]))
        return found


class Recorded(Protocol):
    """The interface of a recording that a report needs."""

    world: Any
    info: Any
    about: dict[str, str]
    end: int
    truncated: bool

    def samples(self) -> Iterator[tuple[int, str, dict[str, Any]]]:
        """Yield time, key below the prefix and payload, in order."""


def of_recording(recording: Recorded) -> ReportInput:
    """Return the content of a recording."""
    story = Story()
    for _, key, payload in recording.samples():
        occurrence = sampled(key, payload)
        if occurrence is not None:
            story.take(occurrence)
    # Time continues after the last event, but a damaged file may have any end.
    story.end(recording.end if recording.end <= LATEST else None)
    notes = ["Energy is sampled from battery_state, about once a second."] if story.metered else []
    # This is known only after everything was read.
    if recording.truncated:
        notes.append("The recording is truncated: later events are missing.")
    if story.began:
        notes.append(
            f"It begins {story.began / NANOSECONDS:.1f} s after the simulation did; earlier events are missing."
        )
    if not story.seen:
        notes.append("It lacks the initial state: states and distances may be wrong.")
    complete = not recording.truncated
    source = Source(kind="recording", exact=story.seen, complete=complete, notes=(*notes, *notes_of(story)))
    seed = recording.about.get("seed", "")
    header = {**recording.info, "seed": int(seed)} if _SEED.fullmatch(seed) else recording.info
    return ReportInput(story, source, header, recording.world)


_SEED: Final = re.compile(r"[0-9]{1,20}")


def sampled(key: str, payload: Mapping[str, Any]) -> Occurrence | None:
    """Return the occurrence of a sample of a recording, if it has one."""
    if not isinstance(payload, dict):
        return None
    try:
        if key == "_world/events":
            return occurrence_of(payload)
        if key == "_world/scene":
            return Occurrence(time_of(payload.get("stamp")), SceneSeen(payload))
        robot, _, topic = key.partition("/")
        if topic == "battery_state":
            header = payload.get("header")
            at = time_of(header.get("stamp") if isinstance(header, dict) else None)
            return Occurrence(at, _battery(robot, payload))
    except Misfit:
        return None
    return None


def _battery(robot: str, state: Mapping[str, Any]) -> BatterySeen:
    """Return the energy of a battery state in ampere hours, by the nominal voltage that its voltage implies."""
    share = number(state, "percentage")
    if not 0.0 <= share <= 1.0:
        raise Misfit("percentage is not a share")
    if state.get("voltage") is None or state.get("charge") is None:
        return BatterySeen(robot, share)
    return BatterySeen(robot, share, number(state, "charge") * number(state, "voltage") / voltage_at(share) * 3600.0)


_MISSING: Final = (
    "The trace could not be replayed exactly ({why}), so the report is made from its lines alone. "
    "It lacks distances, energy, the usage of lanes, the times when robots drove (they count as busy), "
    "and the goal messages of the robots' own scripts."
)


def as_written(lines: Iterable[str], why: str) -> list[ReportInput]:
    """Return the content of each section of a trace from its lines alone, and *why*.

    Raises:
        TraceError: A line is none of a trace.
    """
    found: list[_Section] = []
    for i, line in enumerate(lines, 1):
        if i == 1 or (line.endswith("\n") and begins_section(line)):
            found.append(_Section(header_of(line, i)))
        elif line.endswith("\n"):
            found[-1].take(line, f"line {i}")
    return [section.content(why, complete=section is not found[-1] or section.last == "end") for section in found]


class _Section:
    """A section that is being read.

    Attributes:
        last: The kind of its last line.
    """

    def __init__(self, header: Mapping[str, Any]) -> None:
        self.last = ""
        self._header = header
        self._story = Story()
        self._story.timeline.begin(0)
        for name, robot in _robots(header):
            self._story.robot_log.add(name, robot)

    def take(self, line: str, where: str) -> None:
        """Process the next line of the trace."""
        occurrence, self.last = occurrence_in(line, where)
        self._story.take(occurrence)

    def content(self, why: str, *, complete: bool) -> ReportInput:
        """Return its content, at its end."""
        header, story = self._header, self._story
        story.end()
        notes = [_MISSING.format(why=why)]
        if header["hmrsim"] != __version__:
            notes.append(f"It was written by hmrsim {header['hmrsim']}; this is {__version__}.")
        if not complete:
            notes.append("The trace is truncated: later events are missing.")
        source = Source(kind="trace", exact=False, complete=complete, notes=(*notes, *notes_of(story)))
        return ReportInput(story, source, header, header["world"]["definition"])


def _robots(header: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    robots = header["world"]["definition"].get("robots")
    for name, robot in robots.items() if isinstance(robots, dict) else ():
        kind = robot.get("type", "") if isinstance(robot, dict) else ""
        yield name, kind if isinstance(kind, str) else ""


def occurrence_in(line: str, where: str) -> tuple[Occurrence, str]:
    """Return the occurrence of a line that is no header, and its kind.

    Raises:
        TraceError: It is none of a trace; the error says where it is.
    """
    event = _parsed(line, where)
    try:
        return occurrence_of(event), event["kind"]
    except Misfit as error:
        raise TraceError(f"{where}: {error}") from None


def header_of(line: str, number: int = 1) -> Mapping[str, Any]:
    """Return the fields of a header.

    Raises:
        TraceError: The line is none.
    """
    wrong = TraceError(
        f"line {number}: no header of a trace, and no MCAP; expected a file that was written with --trace or --record"
    )
    try:
        header = _parsed(line, "")
        world = header.get("world")
        if (
            header.get("kind") != "header"
            or not isinstance(world, dict)
            or not isinstance(world.get("definition"), dict)
        ):
            raise wrong
        for fields, key in ((header, "hmrsim"), (world, "name"), (world, "hash")):
            text(fields, key)
    except (Misfit, TraceError):
        raise wrong from None
    return header


def _parsed(line: str, where: str) -> dict[str, Any]:
    try:
        event = from_json(line, allow_inf_nan=False)
    except ValueError as error:
        raise TraceError(f"{where}: {error}") from None
    if not isinstance(event, dict):
        raise TraceError(f"{where}: no JSON object")
    return event
