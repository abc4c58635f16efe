"""The trees of all robots on a terminal, kept up to date: whole where there is room, else a line a robot.

Where not all trees fit, those that run come first, as many of them whole as there is room for.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final

from py_trees.common import Status
from rich.console import Console
from rich.live import Live
from rich.text import Text

from bt_controller.running.snapshot import UNICODE, tip
from bt_controller.watching.display import symbols_for

if TYPE_CHECKING:
    from rich.console import ConsoleOptions, RenderResult

    from bt_controller.running.mission import Mission
    from bt_controller.running.snapshot import Node, Snapshot

_REFRESH: Final = 10
"""Refreshes per wall second: a terminal needs fewer of them than there are ticks."""

_STYLES: Final = {
    Status.SUCCESS: "green",
    Status.FAILURE: "red",
    Status.RUNNING: "blue",
    Status.INVALID: "yellow",
}
_ENDS: Final = {
    Status.RUNNING: "running",
    Status.SUCCESS: "succeeded",
    Status.FAILURE: "failed",
    Status.INVALID: "not begun",
}

_Line = tuple[str, str]
"""A text and its style."""


class LiveDisplay:
    """The renderable for rich: the current trees, no higher and no wider than the terminal."""

    def __init__(self, symbols: Mapping[Status, str] = UNICODE) -> None:
        self._symbols = symbols
        self._more = "…" if symbols is UNICODE else "..."
        self._ticked: dict[str, tuple[Mission, float | None]] = {}
        self._seen: dict[str, tuple[object, Snapshot]] = {}

    @property
    def empty(self) -> bool:
        """Whether there was nothing to show."""
        return not self._ticked

    def ticked(self, mission: Mission, now: float | None) -> None:
        """Process a tick, which is shown at the next refresh."""
        tick = mission, now
        if mission.robot not in self._seen:
            self._seen[mission.robot] = tick, mission.snapshot(now)
        self._ticked[mission.robot] = tick

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """Draw what fits."""
        yield self.text(console.size.height)

    def text(self, height: int) -> Text:
        """Return the trees as lines for a terminal of some height."""
        # What does not fit the width is cut; rich's own mark for that is no ASCII.
        text = Text(no_wrap=True, overflow="ellipsis" if self._symbols is UNICODE else "crop")
        missions = [mission for mission, _ in list(self._ticked.values())]
        for line, style in self._lines(missions, self._room(missions, height)):
            text.append(f"{line}\n", style=style)
        text.rstrip()
        return text

    @staticmethod
    def _room(missions: Sequence[Mission], height: int) -> int:
        """Return the number of available lines: at the end, the outcome of each robot follows below."""
        over = len(missions) if all(mission.over for mission in missions) else 0
        return max(1, height - 1 - min(over, height // 2))

    def _lines(self, missions: Sequence[Mission], room: int) -> Iterator[_Line]:
        waiting = sorted(missions, key=lambda mission: (mission.over, mission.status is Status.SUCCESS))
        if len(missions) > room:
            yield from self._folded([self._snapshot(mission) for mission in waiting[: room - 1]])
            yield self._rest(waiting[room - 1 :])
            return
        trees = [self._snapshot(mission) for mission in missions]
        left = room - sum(1 + len(tree.nodes) for tree in trees)
        if left >= 0:
            for tree in trees:
                yield from self._whole(tree, tree.nodes)
            return
        left = room - len(trees)
        folded = []
        for tree in [self._snapshot(mission) for mission in waiting]:
            nodes = self._fitting(tree.nodes, left, alone=len(trees) == 1)
            left -= len(nodes)
            if nodes:
                yield from self._whole(tree, nodes)
            else:
                folded.append(tree)
        yield from self._folded(folded)

    def _fitting(self, nodes: tuple[Node, ...], room: int, *, alone: bool) -> Sequence[Node]:
        """Return as much of a tree as fits; nothing if that is too little."""
        if len(nodes) <= room:
            return nodes
        open_ones = list(self._without_what_is_over(nodes))
        if 1 < len(open_ones) <= room:
            return open_ones
        running = [node for node in nodes if node.status is nodes[0].status]
        return running[-room:] if alone and room > 0 else ()

    def _without_what_is_over(self, nodes: tuple[Node, ...]) -> Iterator[Node]:
        """Yield behaviors, but none below those that have succeeded or were not begun."""
        closed = sys.maxsize
        for node, following in zip(nodes, (*nodes[1:], nodes[0]), strict=True):
            if node.depth > closed:
                continue
            closed = node.depth if node.status in (Status.SUCCESS, Status.INVALID) else sys.maxsize
            hides = closed == node.depth < following.depth
            yield node._replace(name=f"{node.name} {self._more}") if hides else node

    def _whole(self, tree: Snapshot, nodes: Sequence[Node]) -> Iterator[_Line]:
        yield tree.title, "bold"
        for node in nodes:
            yield node.line(self._symbols), _STYLES[node.status]

    def _folded(self, trees: Sequence[Snapshot]) -> list[_Line]:
        width = max((len(tree.robot) for tree in trees), default=0)
        return [
            (f"{tree.robot:{width}} [{self._symbols[tree.status]}] {tip(tree.nodes).words}", _STYLES[tree.status])
            for tree in trees
        ]

    def _rest(self, missions: Sequence[Mission]) -> _Line:
        counts = Counter(_ENDS[mission.status] for mission in missions)
        ends = ", ".join(f"{counts[end]} {end}" for end in _ENDS.values() if counts[end])
        return f"{self._more} and {len(missions)} more: {ends}", "bold"

    def _snapshot(self, mission: Mission) -> Snapshot:
        """Return the tree; one that was stopped as it was before.

        So is one that is being ticked: what a behavior prints has the terminal drawn anew, in the middle of the tick.
        """
        tick = self._ticked[mission.robot]
        seen, snapshot = self._seen[mission.robot]
        if seen is not tick and (new := mission.glimpse(tick[1])) is not None:
            stopped = new.ended and new.status is Status.INVALID
            snapshot = snapshot if stopped else new
            self._seen[mission.robot] = tick, snapshot
        return snapshot


@contextmanager
def live_display() -> Iterator[LiveDisplay]:
    """Draw trees on the terminal meanwhile; the last ones stay there."""
    display = LiveDisplay(symbols_for(sys.stdout))
    # Log lines are written above the trees, unless the log goes elsewhere.
    console, logs_here = Console(file=sys.stdout), sys.stderr.isatty()
    with Live(display, console=console, refresh_per_second=_REFRESH, redirect_stderr=logs_here) as live:
        try:
            yield display
        finally:
            live.transient = display.empty
