"""The places in a report: lanes, segments off the lanes, doors, lifts and docks."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Final

from hmrsim.report import model
from hmrsim.report.goals import count_waits
from hmrsim.report.html import in_seconds, rounded

if TYPE_CHECKING:
    from hmrsim.history.facilities import Use
    from hmrsim.report.goals import WaitRecord
    from hmrsim.report.story import Story

_MAX_PATHS: Final = 5000


def lanes_of(story: Story) -> Iterator[model.Lane]:
    """Return the usage of lanes, by name; that off the lanes comes first."""
    drives, meters, times = Counter[Any](), defaultdict[Any, list[float]](list), Counter[Any]()
    for track in story.robot_log.tracks.values():
        for lane, use in track.lanes.items():
            drives[lane] += use.drives
            meters[lane].append(use.distance)
            times[lane] += use.time
    waits, waited = defaultdict[Any, list["WaitRecord"]](list), Counter[Any]()
    for wait in story.waiting.wait_records:
        if wait.kind == "way":
            waits[wait.lane].append(wait)
            waited[wait.lane] += wait.length
    closed = story.lanes.uses
    both = {*closed, *((b, a) for a, b in closed)}
    for lane in sorted({*drives, *waits, *both}, key=lambda each: each or ("", "")):
        shut = closed.get(lane) or (closed.get((lane[1], lane[0])) if lane else None)
        if lane in both and not drives[lane] and lane not in waits and lane not in closed:
            continue
        yield model.Lane(
            begin=lane[0] if lane else "",
            end=lane[1] if lane else "",
            drives=drives[lane],
            distance=rounded(math.fsum(meters[lane])),
            seconds=in_seconds(times[lane]),
            waits=count_waits(waits.get(lane, ())),
            waited=in_seconds(waited[lane]),
            closed=in_seconds(shut.time) if shut else 0.0,
        )


def paths_of(story: Story) -> Iterator[model.Path]:
    """Return the segments that were driven off the lanes; if there are too many, the most used ones."""
    paths = Counter[Any]()
    for track in story.robot_log.tracks.values():
        paths.update(track.paths)
    for (begin, end), drives in sorted(paths.most_common(_MAX_PATHS)):
        yield model.Path(begin=begin, end=end, drives=drives)


def fixtures_of(story: Story) -> Iterator[model.Fixture]:
    """Return the usage of doors, lifts and docks."""
    wait_records = story.waiting.wait_records
    whole = story.now - (story.began or 0)
    kinds: tuple[tuple[Any, dict[str, Use]], ...] = (
        ("door", story.doors.uses),
        ("lift", story.lifts.uses),
        ("dock", story.docks.uses),
    )
    for kind, uses in kinds:
        for name, use in sorted(uses.items()):
            waits = [each for each in wait_records if _is_for(each, kind, name)]
            yield model.Fixture(
                name=name,
                kind=kind,
                uses=use.uses,
                robots=len(use.robots),
                seconds=in_seconds(use.time),
                share=min(1.0, use.time / whole) if whole else 0.0,
                waits=count_waits(waits),
                waited=in_seconds(sum(wait.length for wait in waits)),
                longest_queue=use.queue if kind == "dock" else None,
            )


def _is_for(wait: WaitRecord, kind: str, name: str) -> bool:
    """Return whether a robot waited for a door, lift or dock; a reason begins with the door's or lift's name."""
    if kind == "dock":
        return wait.kind == "dock" and wait.why == name
    return wait.kind == "way" and wait.why.startswith(f"{name} is ")
