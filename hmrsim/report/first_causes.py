"""The first causes of the waits of a run: each wait is traced back from robot to robot while it lasts."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Final, NamedTuple

if TYPE_CHECKING:
    from hmrsim.history.robots import State
    from hmrsim.report.goals import WaitRecord
    from hmrsim.report.robots import Track

_MAX_DEPTH: Final = 50
"""Robots in a row up to which a wait is followed."""


class FirstCause(NamedTuple):
    """The cause at the start of a chain of waits.

    Attributes:
        what: A robot, an obstacle in words, or the robots of a circle.
        state: The state of the robot, or ``obstacle``, ``queue``, ``turn`` or ``circle``.
    """

    what: str
    state: str


def first_causes(tracks: Mapping[str, Track]) -> dict[FirstCause, Counter[str]]:
    """Return how long robots waited because of each cause, in nanoseconds by robot; the tracks must have ended.

    Of several robots in the way, the first by name counts that does not drive on.
    """
    known = {name: Past(track) for name, track in tracks.items()}
    found: dict[FirstCause, Counter[str]] = defaultdict(Counter)
    for name, past in known.items():
        for wait in past.waits:
            for cause, time in _followed(wait, wait.began, wait.ended or wait.began, known, (name,)):
                found[cause][name] += time
    return found


class Past:
    """The states and waits of a robot whose track has ended, in order of time; waits must not overlap."""

    def __init__(self, track: Track) -> None:
        self._spans = track.spans
        self._starts = [began for began, _, _ in track.spans]
        self.waits = sorted(track.stood, key=lambda wait: wait.began)
        self._waits_from = [wait.began for wait in self.waits]
        self._changes = sorted(
            {at for began, ended, _ in track.spans for at in (began, ended)}
            | {at for wait in self.waits for at in (wait.began, wait.ended or wait.began)}
        )

    def changes(self, began: int, ended: int) -> Sequence[int]:
        """Return when its state or wait changes between two times."""
        return self._changes[bisect_right(self._changes, began) : bisect_left(self._changes, ended)]

    def state_at(self, at: int) -> str:
        """Return its state at a time; idle if it did not exist."""
        number = bisect_right(self._starts, at) - 1
        return self._spans[number][2] if number >= 0 and at < self._spans[number][1] else "idle"

    def spans_within(self, began: int, ended: int) -> Sequence[tuple[int, int, State]]:
        """Return the spans that may overlap a period."""
        return self._spans[max(0, bisect_right(self._starts, began) - 1) : bisect_left(self._starts, ended)]

    def waits_within(self, began: int, ended: int) -> Sequence[WaitRecord]:
        """Return the waits that may overlap a period."""
        first = max(0, bisect_right(self._waits_from, began) - 1)
        return self.waits[first : bisect_left(self._waits_from, ended)]

    def wait_at(self, at: int) -> WaitRecord | None:
        """Return its wait at a time, if it waits."""
        number = bisect_right(self._waits_from, at) - 1
        return self.waits[number] if number >= 0 and at < (self.waits[number].ended or 0) else None


def _followed(
    wait: WaitRecord, began: int, ended: int, known: Mapping[str, Past], path: tuple[str, ...]
) -> Iterator[tuple[FirstCause, int]]:
    """Yield what starts a wait of the last robot of a path, and for how long, within a part of the wait."""
    others = [name for name in wait.robots if name in known]
    if wait.kind == "dock" or wait.why or not others:
        state = "queue" if wait.kind == "dock" else "obstacle" if wait.why else "turn"
        yield FirstCause(wait.what, state), ended - began
        return
    changes = {at for name in others for at in known[name].changes(began, ended)}
    for since, until in pairwise(sorted({began, ended, *changes})):
        states = [(name, known[name].state_at(since)) for name in others]
        other, state = next((each for each in states if each[1] != "driving"), states[0])
        further = known[other].wait_at(since) if len(path) < _MAX_DEPTH else None
        if other in path:
            circle = ", ".join(sorted(path[path.index(other) :]))
            yield FirstCause(circle, "circle"), until - since
        elif further is not None:
            yield from _followed(further, since, until, known, (*path, other))
        else:
            yield FirstCause(other, state), until - since
