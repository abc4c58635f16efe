"""Showing trees while they run: live on a terminal, as plain lines elsewhere, as JSON for programs."""

from __future__ import annotations

import json
import sys
from typing import IO, TYPE_CHECKING, Final, Protocol

from py_trees.common import Status

from bt_controller.snapshot import ASCII, UNICODE, Node, Snapshot

if TYPE_CHECKING:
    from collections.abc import Mapping
    from contextlib import AbstractContextManager

    from rich.text import Text

_STYLES: Final = {
    Status.SUCCESS: "green",
    Status.FAILURE: "red",
    Status.RUNNING: "blue",
    Status.INVALID: "yellow",
}


class Display(Protocol):
    """What trees are shown on."""

    def show(self, snapshot: Snapshot) -> None:
        """Show a tree after a tick."""


class _Changes:
    """Remembers what was shown, so that only what is new is shown."""

    def __init__(self) -> None:
        self._last: dict[str, tuple[Node, ...]] = {}

    def new(self, snapshot: Snapshot) -> bool:
        """Return whether the tree looks different from the last time."""
        if self._last.get(snapshot.robot) == snapshot.nodes:
            return False
        self._last[snapshot.robot] = snapshot.nodes
        return True


class PlainDisplay:
    """Writes a tree as text whenever it looks different."""

    def __init__(self, out: IO[str]) -> None:
        self._out = out
        self._symbols = symbols_for(out)
        self._changes = _Changes()

    def show(self, snapshot: Snapshot) -> None:
        """Write the tree, if it has changed."""
        if self._changes.new(snapshot):
            lines = [snapshot.title, *(node.line(self._symbols) for node in snapshot.nodes), ""]
            self._out.write("\n".join(lines) + "\n")
            self._out.flush()


class JsonDisplay:
    """Writes a tree as one line of JSON whenever it looks different."""

    def __init__(self, out: IO[str]) -> None:
        self._out = out
        self._changes = _Changes()

    def show(self, snapshot: Snapshot) -> None:
        """Write the tree, if it has changed."""
        if self._changes.new(snapshot):
            self._out.write(json.dumps(snapshot.to_json()) + "\n")
            self._out.flush()


class LiveDisplay:
    """Keeps the trees of all robots on a terminal up to date."""

    def __init__(self, symbols: Mapping[Status, str] = UNICODE) -> None:
        self._symbols = symbols
        self._latest: dict[str, Snapshot] = {}

    def show(self, snapshot: Snapshot) -> None:
        """Put the tree in the place of the robot's last one."""
        self._latest[snapshot.robot] = snapshot

    def text(self) -> Text:
        """Return all trees; a terminal needs them less often than they are ticked."""
        from rich.text import Text  # noqa: PLC0415 - slow to load

        text = Text()
        for snapshot in list(self._latest.values()):
            text.append(f"{snapshot.title}\n", style="bold")
            for node in snapshot.nodes:
                text.append(f"{node.line(self._symbols)}\n", style=_STYLES[node.status])
        return text


def symbols_for(out: IO[str]) -> Mapping[Status, str]:
    """Return the symbols that a stream can take."""
    try:
        "".join(UNICODE.values()).encode(getattr(out, "encoding", None) or "utf-8")
    except UnicodeError:
        return ASCII
    return UNICODE


def live_display() -> tuple[AbstractContextManager[object], LiveDisplay]:
    """Return a display on the terminal, and what has to be entered while it is used."""
    from rich.console import Console  # noqa: PLC0415 - slow to load
    from rich.live import Live  # noqa: PLC0415

    display = LiveDisplay(symbols_for(sys.stdout))
    console = Console(file=sys.stdout)
    return Live(console=console, refresh_per_second=10, get_renderable=display.text), display
