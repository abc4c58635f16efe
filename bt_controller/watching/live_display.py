"""A live display of the trees of all robots on a terminal.

If all trees fit, each is shown as a whole. Otherwise running trees come first: as many as fit are shown as wholes, and
each of the others as one line.
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
    """Draws the current trees with rich, no higher and no wider than the terminal."""

    def __init__(self, symbols: Mapping[Status, str] = UNICODE) -> None:
        self._symbols = symbols
        self._more = "…" if symbols is UNICODE else "..."
        self._ticked: dict[str, tuple[Mission, float | None]] = {}
        self._seen: dict[str, tuple[object, Snapshot]] = {}

    @property
    def empty(self) -> bool:
        """True if there was nothing to show."""
        return not self._ticked

    def ticked(self, mission: Mission, now: float | None) -> None:
        """Record a tick of a mission, to be shown at the next refresh."""
        tick = mission, now
        if mission.robot not in self._seen:
            self._seen[mission.robot] = tick, mission.snapshot(now)
        self._ticked[mission.robot] = tick

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """Draw the trees that fit the terminal."""
        yield self.text(console.size.height)

    def text(self, height: int) -> Text:
        """Return the trees as text for a terminal with a number of lines."""
        # Lines are truncated to the width; rich marks that with a character that is not ASCII.
        text = Text(no_wrap=True, overflow="ellipsis" if self._symbols is UNICODE else "crop")
        missions = [mission for mission, _ in list(self._ticked.values())]
        for line, style in self._lines(missions, self._room(missions, height)):
            text.append(f"{line}\n", style=style)
        text.rstrip()
        return text

    @staticmethod
    def _room(missions: Sequence[Mission], height: int) -> int:
        """Return the number of lines for trees: at the end, some stay free for the outcomes printed below."""
        over = len(missions) if all(mission.over for mission in missions) else 0
        return max(1, height - 1 - min(over, height // 2))

    def _lines(self, missions: Sequence[Mission], room: int) -> Iterator[_Line]:
        waiting = sorted(missions, key=lambda mission: (mission.over, mission.status is Status.SUCCESS))
        if len(missions) > room:
            yield from self._folded([self._snapshot(mission) for mission in waiting[: room - 1]])
            yield self._rest(waiting[room - 1 :])
            return
        trees = [self._snapshot(mission) for mission in missions]
        if sum(1 + len(tree.nodes) for tree in trees) <= room:
            for tree in trees:
                yield from self._whole(tree, tree.nodes)
            return
        remaining = room - len(trees)
        folded = []
        for tree in [self._snapshot(mission) for mission in waiting]:
            nodes = self._fitting(tree.nodes, remaining, alone=len(trees) == 1)
            remaining -= len(nodes)
            if nodes:
                yield from self._whole(tree, nodes)
            else:
                folded.append(tree)
        yield from self._folded(folded)

    def _fitting(self, nodes: tuple[Node, ...], room: int, *, alone: bool) -> Sequence[Node]:
        """Return the nodes of a tree that fit; an empty list if too few would fit."""
        if len(nodes) <= room:
            return nodes
        unfinished = list(self._collapsed(nodes))
        if 1 < len(unfinished) <= room:
            return unfinished
        running = [node for node in nodes if node.status is nodes[0].status]
        return running[-room:] if alone and room > 0 else ()

    def _collapsed(self, nodes: tuple[Node, ...]) -> Iterator[Node]:
        """Yield the nodes of a tree without the children of those that have succeeded or have not begun."""
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
        """Return the current tree or, if it was stopped or is being ticked, the one before.

        A tree can be drawn in the middle of a tick: rich refreshes the terminal when a behavior prints something.
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
    """Draw trees on the terminal within the context; the last state stays on the terminal."""
    display = LiveDisplay(symbols_for(sys.stdout))
    # Log lines are written above the trees, unless the log goes elsewhere.
    console, logs_here = Console(file=sys.stdout), sys.stderr.isatty()
    with Live(display, console=console, refresh_per_second=_REFRESH, redirect_stderr=logs_here) as live:
        try:
            yield display
        finally:
            live.transient = display.empty
