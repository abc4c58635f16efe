"""Reading a trace or a recording into the story of a run; no other file is read."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, Final, NamedTuple, Protocol

from pydantic_core import from_json

from hmrsim import __version__
from hmrsim.components.battery import voltage_at
from hmrsim.engine.sim_time import stamp
from hmrsim.errors import TraceError
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.report.model import Source
from hmrsim.report.occurrence import (
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
from hmrsim.report.robot_log import RobotLog
from hmrsim.report.sink import ReportSink
from hmrsim.report.story import Story
from hmrsim.report.wording import times
from hmrsim.trace.replay import replay

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator


class ReportInput(NamedTuple):
    """The content of a trace or a recording.

    Attributes:
        source: The kind and the quality of the source.
        header: The trace's first line, or a recording's world information.
        definition: The world, as in a native file.
    """

    story: Story
    source: Source
    header: Mapping[str, Any]
    definition: Mapping[str, Any]


def of_trace(lines: Callable[[], Iterable[str]]) -> ReportInput:
    """Return the content of a trace by replaying it; if the replay differs, from its lines alone.

    Args:
        lines: Returns its lines with their ends, from the first one; called twice if necessary. A last line without
            an end is incomplete, and left out.

    Raises:
        TraceError: It is not a trace.
    """
    first = next(iter(lines()), "")
    header = _header(first)
    story, watchers = Story(), list[ReportSink]()

    def watch(simulator: Simulator) -> list[ReportSink]:
        watchers.append(ReportSink(simulator, story.take))
        return watchers

    try:
        outcome = replay(lines(), watch)
    except TraceError as error:
        return _as_written(lines(), header, f"this version can't replay it ({error})")
    if outcome.difference is not None:
        return _as_written(lines(), header, f"the replay differs from line {outcome.difference.line} on")
    watchers[0].weigh_all()
    story.end(stamp(outcome.sections[-1].sim_time))
    notes = () if outcome.complete else ("The trace is truncated: later events are missing.",)
    source = Source(kind="trace", exact=True, complete=outcome.complete, notes=(*notes, *_misfits(story)))
    return ReportInput(story, source, header, header["world"]["definition"])


_MISSING: Final = (
    "The trace could not be replayed exactly ({why}), so the report is made from its lines alone. "
    "It lacks distances, energy, the usage of lanes, the times when robots drove (they count as busy), "
    "and the goal messages of the robots' own scripts."
)


def _as_written(lines: Iterable[str], header: Mapping[str, Any], why: str) -> ReportInput:
    """Return the content of a trace from its lines alone."""
    story, last = Story(robot_log=RobotLog(began=0)), ""
    for name, robot in _robots(header):
        story.robot_log.add(name, robot)
    for i, line in enumerate(lines, 1):
        if i == 1 or not line.endswith("\n"):
            continue
        event = _parsed(line, f"line {i}")
        try:
            occurrence = occurrence_of(event)
        except Misfit as error:
            raise TraceError(f"line {i}: {error}") from None
        last = event["kind"]
        story.take(occurrence)
    story.end()
    notes = [_MISSING.format(why=why)]
    if header["hmrsim"] != __version__:
        notes.append(f"It was written by hmrsim {header['hmrsim']}; this is {__version__}.")
    if last != "end":
        notes.append("The trace is truncated: later events are missing.")
    source = Source(kind="trace", exact=False, complete=last == "end", notes=(*notes, *_misfits(story)))
    return ReportInput(story, source, header, header["world"]["definition"])


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
        occurrence = _sampled(key, payload)
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
    source = Source(kind="recording", exact=story.seen, complete=complete, notes=(*notes, *_misfits(story)))
    seed = recording.about.get("seed", "")
    header = {**recording.info, "seed": int(seed)} if _SEED.fullmatch(seed) else recording.info
    return ReportInput(story, source, header, recording.world)


_SEED: Final = re.compile(r"[0-9]{1,20}")


def _sampled(key: str, payload: Mapping[str, Any]) -> Occurrence | None:
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


def _misfits(story: Story) -> Iterator[str]:
    if story.misfits:
        first = f"first {story.first_misfit}"
        yield f"{story.misfits} events are ignored, as this version can't read them ({first})."
    if story.restarts:
        yield f"Simulated time was reset ({times(story.restarts)}); here it continues."


def _robots(header: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    robots = header["world"]["definition"].get("robots")
    for name, robot in robots.items() if isinstance(robots, dict) else ():
        kind = robot.get("type", "") if isinstance(robot, dict) else ""
        yield name, kind if isinstance(kind, str) else ""


def _header(line: str) -> Mapping[str, Any]:
    wrong = TraceError(
        "line 1: no header of a trace, and no MCAP; expected a file that was written with --trace or --record"
    )
    try:
        header = _parsed(line, "line 1")
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
