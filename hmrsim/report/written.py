"""Reading a trace's lines alone, where it can't be replayed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, Final

from pydantic_core import from_json

from hmrsim import __version__
from hmrsim.errors import TraceError
from hmrsim.report.content import ReportInput, notes_of
from hmrsim.report.model import Source
from hmrsim.report.occurrence import Misfit, Occurrence, occurrence_of, text
from hmrsim.report.robot_log import RobotLog
from hmrsim.report.story import Story
from hmrsim.trace.sections import begins_section

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
        self._story = Story(robot_log=RobotLog(began=0))
        for name, robot in _robots(header):
            self._story.robot_log.add(name, robot)

    def take(self, line: str, where: str) -> None:
        """Take its next line."""
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
