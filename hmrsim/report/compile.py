"""Compiling the story of a run to its report: sums, shares and groups."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from hmrsim.events.traffic import MadeRoom, Rerouted
from hmrsim.faults import SUBJECTS
from hmrsim.history.robots import STATES, State
from hmrsim.protocol.goal import GoalStatus
from hmrsim.report import model
from hmrsim.report.figures import (
    demand_of,
    errors_of,
    fixtures_of,
    goal_of,
    lanes_of,
    orders_of,
    paths_of,
    throughput_of,
)
from hmrsim.report.first_causes import first_causes
from hmrsim.report.goals import count_waits
from hmrsim.report.html import as_text, in_seconds, rounded, times

if TYPE_CHECKING:
    from hmrsim.history.history import Fault
    from hmrsim.report.goals import GoalRecord, WaitRecord
    from hmrsim.report.model import Source
    from hmrsim.report.robots import Track
    from hmrsim.report.story import Story

_MAX_POINTS: Final = 300
"""Maximum points of a battery's curve."""


def report_of(inputs: ReportInput) -> model.Report:
    """Return the report of a run, whose story must have ended."""
    story, source = inputs.story, inputs.source
    goals = [goal_of(goal, exact=source.exact) for goal in story.goal_log.goals]
    robots = _robots(story, exact=source.exact)
    orders = [*orders_of(story, exact=source.exact)]
    waits = [_wait(wait) for wait in story.waiting.wait_records]
    return model.Report(
        source=source,
        world=_world(inputs),
        summary=_summary(story, robots, waits, exact=source.exact),
        robots=tuple(robots),
        goals=tuple(goals),
        errors=tuple(errors_of(story)),
        waits=tuple(waits),
        first_causes=tuple(_first_causes(story)),
        states=tuple(_spans(story.robot_log.tracks.values())),
        faults=tuple(_fault(fault) for fault in story.faults.all),
        deadlocks=tuple(
            model.Deadlock(at=in_seconds(at), robots=names, lanes=lanes) for at, names, lanes in story.waiting.deadlocks
        ),
        lanes=tuple(lanes_of(story)),
        paths=tuple(paths_of(story)),
        fixtures=tuple(fixtures_of(story)),
        demand=demand_of(story, orders, exact=source.exact),
        orders=tuple(orders),
        throughput=tuple(throughput_of(story)),
        batteries={
            name: curve for name, track in sorted(story.robot_log.tracks.items()) if (curve := _thinned(track.curve))
        },
        events=dict(sorted(story.counts.items())),
    )


def _first_causes(story: Story) -> Iterator[model.FirstCause]:
    """Yield what started the waits, the longest first."""
    found = first_causes(story.robot_log.tracks)
    for cause, waited in sorted(found.items(), key=lambda each: (-each[1].total(), each[0])):
        longest = sorted(waited, key=lambda robot: (-waited[robot], robot))
        whole = in_seconds(waited.total())
        yield model.FirstCause(cause=cause.what, state=cause.state, seconds=whole, robots=tuple(longest))


def section_of(inputs: ReportInput) -> model.Section:
    """Return the report of a section of a trace."""
    number, cause = inputs.header.get("section", 1), as_text(inputs.header.get("cause"))
    return model.Section(section=number if isinstance(number, int) else 1, cause=cause, report=report_of(inputs))


def _world(inputs: ReportInput) -> model.World:
    header, definition = inputs.header, inputs.definition
    said = header.get("world")
    named: Mapping[str, Any] = said if isinstance(said, dict) else {}
    units = definition.get("units", "m")
    return model.World(
        name=as_text(named.get("name", definition.get("name", ""))),
        hash=as_text(named.get("hash", "")),
        units=units if isinstance(units, str) else "m",
        seed=_whole(header.get("seed")),
        hmrsim=as_text(header.get("hmrsim", header.get("version", ""))),
        contract=_whole(header.get("contract")),
    )


def _whole(value: Any) -> int | None:
    return value if isinstance(value, int) else None


def _summary(story: Story, robots: list[model.Robot], waits: list[model.Wait], *, exact: bool) -> model.Summary:
    goals = story.goal_log.goals
    statuses = Counter(goal.status.name for goal in goals)
    actions: dict[str, Counter[str]] = defaultdict(Counter)
    for goal in goals:
        actions[goal.action][goal.status.name] += 1
    ended = sum(statuses[status] for status in model.ENDED)
    energy = [robot for robot in robots if robot.energy_used is not None]
    return model.Summary(
        sim_time=in_seconds(story.now - (story.began or 0)),
        robots=len(robots),
        goals=len(goals),
        by_status=dict(sorted(statuses.items())),
        by_action={name: dict(sorted(counts.items())) for name, counts in sorted(actions.items())},
        rejected=len(story.goal_log.rejected),
        success_rate=statuses["SUCCEEDED"] / ended if ended else None,
        distance=rounded(math.fsum(robot.distance or 0.0 for robot in robots)) if exact else None,
        energy_used=rounded(math.fsum(robot.energy_used or 0.0 for robot in energy)) if energy else None,
        energy_charged=rounded(math.fsum(robot.energy_charged or 0.0 for robot in energy)) if energy else None,
        waits=count_waits(story.waiting.wait_records),
        waited=rounded(math.fsum(wait.duration for wait in waits)),
        reroutes=story.counts[Rerouted.kind],
        made_room=story.counts[MadeRoom.kind],
        deadlocks=len(story.waiting.deadlocks),
        faults=len(story.faults.all),
    )


def _robots(story: Story, *, exact: bool) -> list[model.Robot]:
    goals = defaultdict[str, list["GoalRecord"]](list)
    for goal in story.goal_log.goals:
        goals[goal.robot].append(goal)
    tracks = sorted(story.robot_log.tracks.items())
    return [_robot(track, goals[name], track.stood, exact=exact) for name, track in tracks]


def _robot(track: Track, goals: list[GoalRecord], wait_records: list[WaitRecord], *, exact: bool) -> model.Robot:
    times: Counter[State] = Counter()
    for began, ended, state in track.spans:
        times[state] += ended - began
    whole = sum(times.values())
    whom: Counter[str] = Counter()
    for wait in wait_records:
        for what in wait.robots or (wait.what,):
            whom[what] += wait.length
    statuses = Counter(goal.status for goal in goals)
    metered = track.charge is not None
    return model.Robot(
        name=track.name,
        type=track.type,
        began=in_seconds(track.began),
        ended=in_seconds(track.ended if track.ended is not None else track.began),
        distance=rounded(track.distance) if exact else None,
        energy_used=rounded(track.used) if metered else None,
        energy_charged=rounded(track.charged) if metered else None,
        battery=rounded(track.curve[-1][1]) if track.curve else None,
        lowest_battery=rounded(min(share for _, share in track.curve)) if track.curve else None,
        seconds={state: in_seconds(times[state]) for state in STATES},
        share={state: times[state] / whole if whole else float(state == "idle") for state in STATES},
        goals=len(goals),
        succeeded=statuses[GoalStatus.SUCCEEDED],
        failed=statuses[GoalStatus.ABORTED],
        canceled=statuses[GoalStatus.CANCELED],
        waits=count_waits(wait_records),
        waited=in_seconds(sum(wait.length for wait in wait_records if wait.kind == "way")),
        queued=in_seconds(sum(wait.length for wait in wait_records if wait.kind == "dock")),
        waited_for={
            what: in_seconds(time) for what, time in sorted(whom.items(), key=lambda each: (-each[1], each[0]))
        },
    )


def _spans(tracks: Iterable[Track]) -> Iterator[model.Span]:
    for track in sorted(tracks, key=lambda each: each.name):
        for began, ended, state in track.spans:
            yield model.Span(
                robot=track.name,
                state=state,
                began=in_seconds(began),
                ended=in_seconds(ended),
                duration=in_seconds(ended - began),
            )


def _thinned(curve: list[tuple[int, float]]) -> tuple[tuple[float, float], ...]:
    """Return a curve with a limited number of points, which keeps its peaks."""
    if len(curve) > _MAX_POINTS:
        size = math.ceil(len(curve) / (_MAX_POINTS // 3))
        parts = [curve[i : i + size] for i in range(0, len(curve), size)]
        kept = {curve[0], curve[-1]}
        for part in parts:
            kept |= {part[-1], min(part, key=lambda each: each[1]), max(part, key=lambda each: each[1])}
        curve = sorted(kept, key=lambda each: each[0])
    return tuple((in_seconds(at), rounded(share)) for at, share in curve)


def _wait(wait: WaitRecord) -> model.Wait:
    ended = wait.ended or wait.began
    return model.Wait(
        robot=wait.robot,
        began=in_seconds(wait.began),
        ended=in_seconds(ended),
        duration=in_seconds(ended - wait.began),
        kind="dock" if wait.kind == "dock" else "way",
        robots=wait.robots,
        why=wait.why,
        lane=wait.lane,
        x=wait.at[0] if wait.at else None,
        y=wait.at[1] if wait.at else None,
        goal_id=wait.goal.goal_id if wait.goal else "",
        until=wait.until,
    )


def _fault(fault: Fault) -> model.FaultSpan:
    said = fault.settings
    lane = said.get("lane")
    subjects = [
        " → ".join(map(str, lane)) if name == "lane" and isinstance(lane, list) else as_text(said.get(name))
        for name in SUBJECTS
    ]
    known = {*SUBJECTS, "type", "at", "until", "when"}
    detail = ", ".join(f"{key} {value}" for key, value in sorted(said.items()) if key not in known)
    return model.FaultSpan(
        name=fault.name,
        fault=fault.fault,
        subject=next(filter(None, subjects), ""),
        robot=fault.robot,
        began=in_seconds(fault.began),
        ended=None if fault.ended is None else in_seconds(fault.ended),
        detail=detail,
    )


class ReportInput(NamedTuple):
    """The content of a section of a trace, or of a recording.

    Attributes:
        source: The kind and the quality of the source.
        header: The section's first line, or a recording's world information.
        definition: The world, as in a native file.
    """

    story: Story
    source: Source
    header: Mapping[str, Any]
    definition: Mapping[str, Any]


def notes_of(story: Story) -> Iterator[str]:
    """Yield what should be noted of how a story was read."""
    if story.misfits:
        first = f"first {story.first_misfit}"
        yield f"{story.misfits} events are ignored, as this version can't read them ({first})."
    if story.timeline.restarts:
        yield f"Simulated time was reset ({times(story.timeline.restarts)}); here it continues."
